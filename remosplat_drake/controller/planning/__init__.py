"""Planning: searches paths if no rollout of guidance reaches the target.

All other candidates of guidance only modify the quadratic program of a tick.
This is not sufficient, for example, to unfold an arm that is folded the wrong
way. So planning searches a path through configurations, with the map and the
distances that verification uses. The path is a further candidate of guidance.
Safety does not depend on it.
"""
