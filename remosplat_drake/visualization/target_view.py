"""`TargetView`: draws a target and its free directions on the page."""

import numpy as np
from pydrake.geometry import Cylinder, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.signals.target import DIRECTIONS, Target
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.shapes import (
    draw_triad,
    rigid_transform,
    tube_mesh,
)

_FREE = Rgba(1.0, 0.86, 0.0, 0.9)
_PASSED = Rgba(1.0, 0.86, 0.0, 0.25)
_LINE = Rgba(0.95, 0.45, 0.10)
_RING = 0.09  # Radius of the ring about an axis that may turn [m].
_ROD = 0.6  # Length of the rod along a way that is free [m].


class TargetView:
    """Draws the axes of a target, and its free directions in yellow.

    A ring marks an axis about which the tool may turn, a ball a free
    orientation, and a rod an axis along which the tool may move. A pale ball
    marks a target that the end effector passes without a stop. An orange line
    is the straight path on which the end effector must reach its target.

    Args:
        page: The page to draw on.
        path: Path in the scene tree below which the target is drawn.
    """

    def __init__(self, page: MeshcatPage, path: str):
        self._scene, self._meshcat = page.scene, page.meshcat
        self._path = path
        self._marks = f"{path}/marks"
        self._lines = f"{path}_lines"
        self._shown: set[str] = set()
        self._drawn: set[str] = set()
        self._targets = 0
        self._latest: Target | None = None
        draw_triad(page.meshcat, path)
        self._scene.set_property(path, "visible", False)

    def update(self, target: Target, time: float):
        """Draws a target.

        Args:
            target: The target; it is hidden while its pose is unknown.
            time: Time in a recording [s].
        """
        known = target.is_known
        self._scene.show(self._path, known, time)
        if not known:
            return
        self._scene.move(self._path, rigid_transform(target.X_WT), time)
        if self._latest is None or not target.equals(self._latest):
            self._latest = target
            self._show(self._marks_of(target), time)

    def _marks_of(self, target: Target) -> set[str]:
        """Draws the marks of a target; returns their paths in the scene."""
        free = set(target.free)
        if {"rx", "ry", "rz"} <= free:
            free -= {"rx", "ry", "rz"}
            free.add("ball")
        paths = {f"{self._marks}/{name}" for name in free}
        for name in free:
            self._draw_mark(name)
        if target.passed_within is not None:
            path = f"{self._marks}/{1e3 * target.passed_within:.0f}mm"
            self._draw(path, Sphere(target.passed_within), _PASSED)
            paths.add(path)
        if target.line is not None:
            paths |= self._line_of(target)
        return paths

    def _line_of(self, target: Target) -> set[str]:
        assert target.line is not None
        ends = np.stack([target.line.X_WA[:3, 3], target.X_WT[:3, 3]])
        if not np.linalg.norm(ends[1] - ends[0]) > 1e-3:
            return set()
        self._targets += 1
        path = f"{self._lines}/{self._targets}"
        vertices, faces = tube_mesh(ends, 0.003)
        self._meshcat.SetTriangleMesh(path, vertices.T, faces.T, _LINE)
        return {path}

    def _draw_mark(self, name: str):
        path = f"{self._marks}/{name}"
        if path in self._drawn:
            return
        if name == "ball":
            self._draw(path, Sphere(0.022), _FREE)
            return
        axis = np.eye(3)[DIRECTIONS.index(name) % 3]
        across = RotationMatrix.MakeFromOneVector(axis, axis_index=2)
        if len(name) == 1:
            self._draw(path, Cylinder(0.003, _ROD), _FREE)
            self._meshcat.SetTransform(path, RigidTransform(across, [0, 0, 0]))
            return
        angle = np.linspace(0.0, 1.9 * np.pi, 40)  # Not quite closed.
        circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        vertices, faces = tube_mesh(
            _RING * circle @ across.matrix().T, radius=0.004
        )
        self._drawn.add(path)
        self._meshcat.SetTriangleMesh(path, vertices.T, faces.T, _FREE)

    def _draw(self, path: str, shape: Cylinder | Sphere, color: Rgba):
        if path not in self._drawn:
            self._drawn.add(path)
            self._meshcat.SetObject(path, shape, color)

    def _show(self, paths: set[str], time: float):
        for path in self._shown ^ paths:
            self._scene.show(path, path in paths, time)
        self._shown = paths
