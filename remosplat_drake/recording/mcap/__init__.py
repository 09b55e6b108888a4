"""A run as an MCAP file, which Foxglove and others open (extra `record`).

It is written by a process of its own. A `McapRecorder` hands it one
`TickRecord` after the other and never waits for it; `recording_process` turns
these into `messages`, described by `schemas`, and adds the images that it
hears on the camera's wire. `McapFile` puts them on the disk.

A tick is put together once, by `TrajectoryLog`, whoever writes it.
"""
