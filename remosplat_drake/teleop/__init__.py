"""Teleoperation: operators' requests, and the motion of the target.

Operators are systems with a port `command`, an `OperatorCommand`:
`TrajectoryOperator` follows a script (`trajectory_file`), `LcmOperator`
receives targets of another program (`target_stream`), and
`visualization.TeleopPanel` has sliders, buttons and a gamepad with a dead-man
switch. `CommandMerger` merges the commands of several operators (`merging`).

`OperatorTarget` moves the target as the command says, within the bounds of
`TeleopConfig`: `target_motion` selects its mode (hold, follow, go, scan),
`target_step` and `smoothing` bound its velocity and acceleration, `scan` finds
the poses from which the wrist camera looks around.
"""
