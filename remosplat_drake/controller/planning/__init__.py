"""Planning: searches paths through configurations if rollouts do not arrive.

Other candidates of guidance only modify the program of a tick. That does not
suffice to unfold an arm that is folded the wrong way. So planning searches a
path through configurations, with the map and the distances that verification
uses. The path is a further candidate of guidance, and safety does not depend on
it.
"""
