"""Stores a session: all data of a teleoperation, in one folder.

| Path                       | Written by                 | When              |
|----------------------------|----------------------------|-------------------|
| `scenario.yaml`            | `Session.create`           | at the beginning  |
| `session.json`             | `Session`                  | each frame or map |
| `session.lock`             | `Session.open_to_write`    | while it is open  |
| `frames/transforms.json`   | `FrameStore`               | each frame        |
| `frames/images/0001.png`   | `FrameStore`               | each frame        |
| `frames/depth/0001.png`    | `FrameStore`               | each frame        |
| `frames/masks/0001.png`    | `FrameStore`               | each frame        |
| `maps/map_0001.rsmap`      | `map_file.write_map`       | each map          |
| `splat.ply`                | the mapping process        | on "Save splat"   |
| `runs/0001/`               | `run_folders.new_run`      | each run          |
| `runs/0001/trajectory.log` | `recording.TrajectoryLog`  | each control tick |
| `runs/0001/events.jsonl`   | `recording.TrajectoryLog`  | each event        |
| `runs/0001/map_knowledge.json` | `remosplat teleop`     | each run on a map |

`app.teleop_session` creates the session. The mapping process then holds the
lock, and writes all files except those in `runs/`. The control process writes
the files in `runs/`. A file is either replaced atomically or only extended. So
if a process is killed, only the data that it was writing are lost.

`app.teleop_session` also opens a session to continue it. `app.recorded_run`
reads a run with its maps for `remosplat replay`.
"""
