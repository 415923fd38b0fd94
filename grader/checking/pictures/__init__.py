"""Judging pictures of the scenes, in the parent: how far from the accepted ones, where, and why.

`plan` says which pictures there are, `expected_files` reads what was made of the reference for
each, `measure` finds what lies outside, `regions`, `causes` and `places` put it into words, `views`
draws it, `image_tools` loads scikit-image for that, and `judgement` is what the checks call.
"""
