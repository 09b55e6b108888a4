"""Records a run: numbers in memory, and files in the folder of the run.

Two systems record a run. `TrajectoryRecorder` stores the numbers of each tick
in a `TickTable`. At the end, the table becomes a `Trajectory`, from which
`run_metrics` computes the metrics of the run. `TrajectoryLog` writes each tick
(`run_log`) and each event (`events`) to files during a teleoperation;
`tick_events` finds the events. From such a log, `trace_operator` computes the
curves of the paper's figure 5, which `draw_operator_figure` draws.

The module `mapping.store` lists the files of a mapping session, and their
writers.
"""
