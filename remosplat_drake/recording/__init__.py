"""Records of a run: numbers in memory, and files in its folder.

Two systems observe a run. `TrajectoryRecorder` stores the numbers of each tick
in a `TickTable`, which becomes a `Trajectory`, from which `run_metrics`
computes the metrics of `results`. `TrajectoryLog` writes every tick (`run_log`)
and every event (`events`; `tick_events` finds them) to files during a
teleoperation. From such a log `trace_operator` computes the curves of the
paper's figure 5, which `draw_operator_figure` draws.

`mapping.store` lists the files of a session, and their writers.
"""
