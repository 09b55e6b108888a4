"""The robot's own convex shapes: which may touch, and how far apart they are.

`shapes` reads them from the model file, `link_pairs` finds which links are
checked, `pairs` places them and calls the kernels for distances.
"""
