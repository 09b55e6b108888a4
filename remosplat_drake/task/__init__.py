"""The task: target poses one after the other, and when one is reached.

`TargetSequence` is the system that hands them out, `has_arrived` the success
rule of the paper. `suggest_task` finds a first target in an unknown scene, at
one of the `HandPlaces` of its grid.
"""
