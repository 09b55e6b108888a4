"""`LiveScene`: moves objects in the scene, for browsers and recordings."""

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

from remosplat_drake.visualization.live_page.newest import Newest

POSE, PROPERTY = "pose", "property"
"""Kinds of values that are sent to browsers: the pose of a path in the scene
tree, and a property of a path."""

Property = bool | float | list[float]
"""Type of a property's value."""


class LiveScene:
    """Moves and changes objects in Meshcat.

    Meshcat would send each motion to each browser. A browser that draws slowly
    would then lag further and further behind. Meshcat therefore gets only the
    shapes, and browsers get only the newest poses, from `Newest`. The recording
    gets all motion.

    Args:
        meshcat: Drake's Meshcat server, which sends the shapes.
        newest: Store of the newest values, from which browsers get them.
    """

    def __init__(self, meshcat: Meshcat, newest: Newest):
        self._meshcat = meshcat
        self._newest = newest
        self._is_recording = False

    def record(self, start: float) -> None:
        """Records all motion from now on.

        Args:
            start: Time at which the recording begins [s].
        """
        self._meshcat.DeleteRecording()
        self._meshcat.StartRecording(frames_per_second=16)
        self._meshcat.get_mutable_recording().set_start_time(start)
        self._is_recording = True

    def pause(self) -> None:
        """Stops recording."""
        self._meshcat.StopRecording()
        self._is_recording = False

    @property
    def start(self) -> float:
        """Time at which the recording begins [s]."""
        return self._meshcat.get_mutable_recording().start_time()

    def move(self, path: str, X_PF: RigidTransform, time: float) -> None:
        """Moves a path of the scene tree.

        Args:
            path: The path.
            X_PF: Pose of the path F in the frame P of its parent.
            time: Time of the motion in a recording [s].
        """
        matrix = X_PF.GetAsMatrix4()
        self._newest.put((POSE, path), matrix.tobytes(order="F"))
        if self._is_recording:
            recording = self._meshcat.get_mutable_recording()
            recording.SetTransform(recording.frame(time), path, X_PF)

    def set_property(
        self,
        path: str,
        name: str,
        value: Property,
        time: float | None = None,
    ) -> None:
        """Changes a property of a path.

        Args:
            path: The path.
            name: Name of the property, such as "visible".
            value: The value.
            time: Time of the change in a recording [s]. If it is None, the
                change is not recorded.
        """
        self._newest.put((PROPERTY, path, name), value)
        if self._is_recording and time is not None:
            recording = self._meshcat.get_mutable_recording()
            frame = recording.frame(time)
            recording.SetProperty(frame, path, name, value)

    def show(self, path: str, visible: bool, time: float) -> None:
        """Shows or hides a path.

        Args:
            path: The path.
            visible: Whether it is shown.
            time: Time of the change in a recording [s].
        """
        self.set_property(path, "visible", visible, time)

    def delete(self, path: str) -> None:
        """Removes a path and all paths below it.

        Args:
            path: The path.
        """
        self._meshcat.Delete(path)
        for kind in (POSE, PROPERTY):
            self._newest.drop((kind, path))

    def settle(self) -> None:
        """Sends all present poses to Meshcat, since saved pages need them."""
        for (_, path), pose in self._newest.of_kind(POSE).items():
            matrix = np.frombuffer(pose).reshape(4, 4).T
            self._meshcat.SetTransform(path, matrix)
        for (_, path, name), value in self._newest.of_kind(PROPERTY).items():
            self._meshcat.SetProperty(path, name, value)
