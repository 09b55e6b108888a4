"""Records a run as an MCAP file, for viewers like Foxglove (extra `record`).

A separate process writes the file. A `McapRecorder` sends each `TickRecord` to
this process, and does not wait for it. The process, `recording_process`,
converts the records to `messages`, which `schemas` describe, and adds the
images that it receives from the camera. `McapFile` writes the messages to disk.

`TrajectoryLog` collects the data of each tick once, for all writers.
"""
