"""A session on disk: everything that a teleoperation gathers, in one folder.

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

All is written by the mapping process, which holds the lock, but for two
things: `app.teleop_session` creates the session, and `runs/` belongs to the
control process. Each file changes at once or only grows, so that a killed
process costs what it was just writing and nothing else.

`app.teleop_session` opens a session to go on with it; `app.recorded_run` reads
a run with its maps for `remosplat replay`.
"""
