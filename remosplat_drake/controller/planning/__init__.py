"""Planning: searches paths through configurations if rollouts do not arrive.

The other candidates of guidance only modify the program: an arm that is folded
the wrong way stays folded. So a path through configurations is searched on the
same map and with the same distances as verification uses. It is a further
candidate of guidance, and safety does not depend on it.
"""
