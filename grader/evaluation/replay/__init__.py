"""A pixel replayed: a submission's functions called one by one along its ray.

The values that they give are held against the maps of the expected data, or against each other, in
the order in which the colour is made: so the first that goes wrong is the one to look at. The
notebook's inspector shows it, and the report names it beside a picture that fails.
"""
