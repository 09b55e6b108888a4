"""The robot's own convex shapes: which may touch, and how far apart they are.

`shapes` reads them off the model file, `link_pairs` finds out which links are
to be watched, `pairs` places them and asks the kernels for distances.
"""
