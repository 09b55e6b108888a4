"""What a run leaves behind: numbers in memory, and files in its folder.

Two systems look on. `TrajectoryRecorder` keeps the numbers of each tick in a
`TickTable`, which becomes a `Trajectory`, of which `run_metrics` makes the
numbers of `results`. `TrajectoryLog` writes every tick (`run_log`) and every
event (`events`; `tick_events` finds them) to files while a teleoperation goes
on. From such a log `trace_operator` computes the curves of the paper's figure
5, which `draw_operator_figure` draws.

`mapping.store` tells which files a session has, and who writes them.
"""
