"""`FrameStore`: the frames of a session, in a folder that is a capture.

`remosplat reconstruct` can read the folder. Images are written before
`transforms.json` lists them, and this file is replaced atomically. So if the
process is interrupted, only the frame that was being added is lost.
"""

import contextlib
import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.json_fields import JsonFields
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame, assemble
from remosplat_drake.capture.readers.nerfstudio import (
    DEPTH_UNIT,
    TRANSFORMS,
    camera_fields,
    read_frame,
    write_images,
)
from remosplat_drake.capture.readers.text_files import read_json
from remosplat_drake.scene.objects.placed_object import PlacedObject

_BASE_POSE = "base_pose"
"""Field of a frame in `transforms.json` that contains the base's pose in a map.
"""

_OBJECTS = "objects"
"""Field of a frame that contains the objects that were known when it was taken.
"""

_NAME = re.compile("frame [0-9]{1,9}")


class FrameStore:
    """The frames of a session, in the order in which they were taken.

    `load` reads the images. A frame's name, "frame 3" for example, is for
    display.
    """

    def __init__(self, folder: Path):
        """Reads the list of frames of a folder.

        Args:
            folder: The folder. Without a `transforms.json`, it contains no
                frames.

        Raises:
            RemoSplatError: `transforms.json` is invalid.
        """
        self._path = folder / TRANSFORMS
        self._document: dict = {
            "camera_model": "OPENCV",
            "depth_unit_scale_factor": DEPTH_UNIT,
            "frames": [],
        }
        if self._path.exists():
            self._document = read_json(self._path)
        document = JsonFields(self._document, str(self._path))
        self._index: dict[str, int] = {}
        sizes = set()
        for i, entry in enumerate(document.inners("frames")):
            name = entry.text("name")
            if not _NAME.fullmatch(name) or name in self._index:
                raise entry.error("name", f"invalid or repeated: {name!r}")
            entry.number("time")
            sizes.add(len(entry.numbers("configuration")))
            if entry.has(_OBJECTS):
                for thing in entry.inners(_OBJECTS):
                    thing.text("name")
                    thing.flag("stands")
                    thing.numbers("pose", 16)
            if entry.has(_BASE_POSE) and len(entry.numbers(_BASE_POSE)) != 3:
                raise entry.error(_BASE_POSE, "expected x, y, yaw")
            if len(sizes) > 1:
                raise entry.error(
                    "configuration",
                    "must have the same length in all frames",
                )
            self._index[name] = i
        self._cache: dict[str, Frame] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all frames, oldest first."""
        return tuple(self._index)

    def add(
        self,
        frame: Frame,
        q: np.ndarray,
        objects: Sequence[PlacedObject] = (),
    ) -> str:
        """Saves a frame, and returns its new name.

        Args:
            frame: The frame; it must have a time.
            q: The robot's configuration when it was taken, shape (n_q,).
            objects: The known objects at that time.

        Raises:
            RemoSplatError: The frame is invalid or cannot be written. Then
                nothing is saved.
        """
        view = assemble(self._path.parent, [frame])
        last = self.names[-1] if self._index else "frame 0"
        number = int(last.split()[-1]) + 1
        height, width = view.size
        entry = {"name": f"frame {number}", "w": width, "h": height}
        entry |= camera_fields(view.K[0])
        entry |= {"time": frame.time, "configuration": q.tolist()}
        if objects:
            entry[_OBJECTS] = [
                {
                    "name": each.name,
                    "pose": each.X_WO.ravel().tolist(),
                    "stands": each.stands,
                }
                for each in objects
            ]
        stem = f"{number:04d}"
        try:
            entry |= write_images(self._path.parent, stem, view)
            self._write([*self._document["frames"], entry])
        except FileError:
            for kind in ("images", "depth", "masks"):
                with contextlib.suppress(OSError):
                    (self._path.parent / kind / f"{stem}.png").unlink()
            raise
        self._index[entry["name"]] = len(self._index)
        return entry["name"]

    def leave_out(self, names: set[str]) -> None:
        """Removes frames from the capture; new frames may reuse their names.

        Raises:
            FileError: `transforms.json` cannot be written.
        """
        kept = [e for e in self._document["frames"] if e["name"] not in names]
        self._write(kept)
        self._index = {entry["name"]: i for i, entry in enumerate(kept)}
        for name in names:
            self._cache.pop(name, None)

    def _write(self, entries: list[dict]) -> None:
        document = self._document | {"frames": entries}
        write_atomically(self._path, json.dumps(document, indent=1) + "\n")
        self._document = document

    def load(self, names: tuple[str, ...]) -> dict[str, str]:
        """Reads frames into memory, and removes all other frames from it.

        Returns:
            Reasons why frames cannot be used, keyed by the frames' names; empty
            if all frames can be used.
        """
        before, self._cache = self._cache, {}
        problems = {}
        for name in names:
            try:
                self._cache[name] = before.get(name) or self._read(name)
            except RemoSplatError as error:
                problems[name] = str(error)
        return problems

    def capture(self, names: tuple[str, ...]) -> Capture:
        """Makes a capture of loaded frames, without any correction.

        Args:
            names: Names of the frames, at least one, which `load` has read.
        """
        frames = [self._cache[name] for name in names]
        return assemble(self._path, frames)

    def _read(self, name: str) -> Frame:
        if name not in self._index:
            raise FileError(self._path, f"there is no {name!r}")
        return read_frame(self._path, self._document, self._index[name])

    def poses(self, names: tuple[str, ...]) -> np.ndarray:
        """Returns the frames' poses X_WC (OpenGL axes), shape (n, 4, 4)."""
        matrices = [self._entry(name)["transform_matrix"] for name in names]
        return np.array(matrices, float).reshape(-1, 4, 4)

    def configurations(self, names: tuple[str, ...]) -> np.ndarray:
        """Returns the configurations at which frames were taken, (n, n_q)."""
        return np.array([self._entry(name)["configuration"] for name in names])

    def objects(self, name: str) -> tuple[PlacedObject, ...]:
        """Returns the objects that were known when a frame was taken."""
        return tuple(
            PlacedObject(
                each["name"],
                np.array(each["pose"], float).reshape(4, 4),
                each["stands"],
            )
            for each in self._entry(name).get(_OBJECTS, ())
        )

    def time(self, name: str) -> float:
        """Returns the time of a frame, on the clock of its run [s]."""
        return float(self._entry(name)["time"])

    def frame(self, name: str) -> Frame:
        """Returns a loaded frame, as it was saved; see `load`."""
        return self._cache[name]

    def base_pose(self, name: str) -> np.ndarray | None:
        """Returns the base's pose in W (x, y, yaw) at a frame.

        Args:
            name: Name of the frame.

        Returns:
            Shape (3,) [m, rad]; None if no map has aligned the frame.
        """
        pose = self._entry(name).get(_BASE_POSE)
        return None if pose is None else np.array(pose, float)

    def note_base_poses(self, poses: dict[str, np.ndarray]) -> None:
        """Records the poses that the base had at the times of frames.

        Args:
            poses: x, y, yaw in W, each of shape (3,) [m, rad], keyed by the
                frames' names; removed frames are ignored.

        Raises:
            FileError: `transforms.json` cannot be written.
        """
        entries = [
            entry | {_BASE_POSE: poses[entry["name"]].tolist()}
            if entry["name"] in poses
            else entry
            for entry in self._document["frames"]
        ]
        self._write(entries)

    def _entry(self, name: str) -> dict:
        return self._document["frames"][self._index[name]]
