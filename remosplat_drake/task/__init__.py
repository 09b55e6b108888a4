"""The task: a sequence of target poses, and the rule of arrival.

`TargetSequence` is the system that outputs them, `has_arrived` the success rule
of the paper. `suggest_task` finds a first target in an unknown scene, on the
grid of `HandPlaces`.
"""
