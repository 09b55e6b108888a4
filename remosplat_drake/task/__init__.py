"""Tasks: sequences of targets, the rule of arrival, and jobs with objects.

The system `TargetSequence` outputs targets one after the other, and
`has_arrived` is the success rule of the paper. `TaskSystem` leads a robot
through the steps of a `Task`, such as picking and placing objects.
`suggest_task` finds a first target in an unknown scene, on the grid of
`HandPlaces`.
"""
