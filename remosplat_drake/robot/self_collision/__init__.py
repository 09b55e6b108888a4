"""Self-collision: the convex shapes of a robot's links, and their distances.

`shapes` reads the shapes from the model file, `link_pairs` determines which
pairs of links are checked, and `pairs` computes their distances with kernels.
"""
