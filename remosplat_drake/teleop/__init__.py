"""Teleoperation: operators' requests, and the motion of the target.

An operator is a system with an output port `command`, an `OperatorCommand`.
`TrajectoryOperator` follows a script (`trajectory_file`), `LcmOperator`
receives targets from another program (`target_stream`), and
`visualization.TeleopPanel` has sliders, buttons and a gamepad with a dead-man
switch. `CommandMerger` merges the commands of several operators (`merging`).

`OperatorTarget` moves the target as the command requests, within the bounds of
`TeleopConfig`. `target_motion` selects the mode of motion (hold, follow, go,
scan), `target_step` and `smoothing` bound velocity and acceleration, and `scan`
computes the poses from which the wrist camera looks around.
"""
