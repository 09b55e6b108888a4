"""Records a run as an MCAP file, for Foxglove and others (extra `record`).

A separate process writes it. A `McapRecorder` sends one `TickRecord` after the
other and never waits for the process; `recording_process` converts these to
`messages`, described by `schemas`, and adds the images that it receives from
the camera. `McapFile` writes them to disk.

`TrajectoryLog` assembles each tick once, for all writers.
"""
