"""`make alike`: programs of a class that are alike, to look at; never a mark.

command     the command line, and who is compared
pieces      what of a program is compared
tools       the tools that find what texts have in common
sharing     what two programs share beyond the usual
page        alike.html, and alike.json for the class page
"""
