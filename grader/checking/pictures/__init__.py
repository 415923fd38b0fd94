"""Judging pictures of the scenes, in the parent: how far from the accepted ones, where, and why.

`plan` says which pictures there are, `stored` reads what was made of the reference for each,
`measure` finds what lies outside, `regions` and `faults` put it into words, `views` draws it, and
`judging` is what the checks call.
"""
