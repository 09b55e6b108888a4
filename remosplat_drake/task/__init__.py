"""Tasks: sequences of targets, the rule of arrival, and jobs with objects.

The system `TargetSequence` outputs targets one after the other. `has_arrived`
is the rule by which a target counts as reached. `TaskSystem` leads a robot
through the steps of a `Task`, such as picking and placing objects.
`suggest_task` finds a first target in an unknown scene, on the grid of
`HandPlaces`.
"""
