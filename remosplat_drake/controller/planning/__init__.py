"""Planning: a path through configurations, where looking ahead is not enough.

Guidance bends the program towards the target; an arm that is folded the wrong
way stays so. Here a path is searched through configurations, on the same map
and with the same distances as verification keeps. It is one more candidate of
guidance: nothing rests on it.
"""
