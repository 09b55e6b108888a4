"""Teleoperation: operators' requests, and the target's motion to them.

Operators are systems with a port `command`, an `OperatorCommand`:
`TrajectoryOperator` follows a script (`trajectory_file`), `LcmOperator` hears
another program (`target_stream`), and `visualization.TeleopPanel` has sliders,
buttons and a gamepad with a dead-man switch. `CommandMerger` makes one of
several (`merging`).

`OperatorTarget` moves the target as the command says, within the bounds of
`TeleopConfig`: `target_motion` decides what it does (hold, follow, go, scan),
`target_step` and `smoothing` bound its velocity and acceleration, `scan` finds
the poses from which the wrist camera looks around.
"""
