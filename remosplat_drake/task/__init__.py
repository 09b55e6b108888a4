"""Tasks: sequences of targets, the arrival rule, and jobs with objects.

The system `TargetSequence` outputs targets in their order. `has_arrived`
decides whether a target counts as reached. `TaskSystem` outputs the steps of a
`Task`, such as picking and placing objects. `suggest_task` finds a first target
in a new scene, on the grid of `HandPlaces`.
"""
