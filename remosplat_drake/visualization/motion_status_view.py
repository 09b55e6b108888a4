"""`MotionStatusView`: highlights the link and the point that stop the robot."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion_status import NOT_STARTED, MotionStatus
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import unsupervised
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.shapes import shine_through, tube_mesh

LINKS = f"{ROOT}/held/links"
PLACE = f"{ROOT}/held/place"

_NAME = "motion_status_view"
_GLOW = Rgba(1.0, 0.55, 0.05, 0.55)
_AMBER = Rgba(1.0, 0.55, 0.05)
_SWELL = 0.004  # The glow lies around the link's own spheres [m].
_RING, _TUBE = 0.05, 0.006  # Radii of the ring about the place [m].


class MotionStatusView(LeafSystem):
    """Highlights the link and the point at which the robot is held or stopped.

    .. pydrake_system::

        name: MotionStatusView
        input_ports:
        - configuration
        - motion_status

    `configuration` takes the measured q, `motion_status` the `MotionStatus`. If
    an obstacle or a limit holds the robot before its target, or the supervisor
    stops it, the affected link glows, and a ring marks the point of the scene,
    the mover or the joint that is the cause, if there is one. A replay shows
    both, too. In a run without a supervisor, this view also shows the sentence
    about the robot's state in the page's bar; otherwise the `SafetyPanel` shows
    it.

    Args:
        page: The page to draw on.
        robot: The robot, which has the links and spheres.
    """

    def __init__(self, *, page: MeshcatPage, robot: RobotModel):
        super().__init__()
        self.set_name(_NAME)
        self._page = page
        self._robot = robot
        self._links: dict[str, bool] = {}
        self._has_place = False
        self._shown = NOT_STARTED
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._motion_status_input = self.DeclareAbstractInputPort(
            "motion_status", Value(NOT_STARTED)
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage, robot: RobotModel
    ) -> "MotionStatusView":
        """Adds a view to a diagram; the caller connects its two ports."""
        return builder.AddSystem(MotionStatusView(page=page, robot=robot))

    def _publish(self, context: Context):
        status = self._motion_status_input.Eval(context)
        if status is self._shown:
            return
        self._shown = status
        q = self._configuration_input.Eval(context)
        self.light_up(status, q, context.get_time())
        state = self._page.state
        if state is not None and not (state.buttons or state.is_over):
            self._page.show(unsupervised(status))

    def light_up(self, status: MotionStatus, q: np.ndarray, time: float):
        """Highlights link and point of a status; removes earlier highlights.

        Args:
            status: The robot's state.
            q: The robot's configuration, shape (n_q,) [m, rad].
            time: Time in a recording [s].
        """
        link = status.link if status.is_obstructed else ""
        # An obstacle may also hold a carried object, which is not a drawn link.
        link = link if link in self._robot.tree.names else ""
        if link and link not in self._links:
            self._add_glow(link)
        X_WL = self._robot.body_poses(q)
        for name, was_lit in self._links.items():
            if name == link:
                X = RigidTransform(X_WL[self._robot.tree.index(name)])
                self._page.scene.move(f"{LINKS}/{name}", X, time)
            if was_lit != (name == link):
                self._links[name] = name == link
                self._page.scene.show(f"{LINKS}/{name}", name == link, time)
        p_W = status.p_W if status.is_obstructed else None
        if p_W is not None:
            if not self._has_place:
                self._has_place = True
                _draw_ring(self._page.meshcat)
                self._page.scene.show(PLACE, False, self._page.scene.start)
            self._page.scene.move(PLACE, self._facing(link, p_W, q), time)
        if self._has_place:
            self._page.scene.show(PLACE, p_W is not None, time)

    def _facing(
        self, link: str, p_W: np.ndarray, q: np.ndarray
    ) -> RigidTransform:
        """Returns the pose of a ring around a place, facing the link."""
        spheres = self._robot.spheres_at(q)
        p_WS = spheres.p_WS[self._robot.spheres.on_links({link})]
        away = p_WS - p_W
        if not len(away):
            return RigidTransform(p_W)
        axis = away[np.argmin((away**2).sum(axis=1))]
        if not axis.any():
            return RigidTransform(p_W)
        return RigidTransform(RotationMatrix.MakeFromOneVector(axis, 2), p_W)

    def _add_glow(self, link: str):
        spheres, path = self._robot.spheres.on_link(link), f"{LINKS}/{link}"
        for i, p_LS in enumerate(spheres.p_LS):
            radius = float(spheres.radius[i]) + _SWELL
            self._page.meshcat.SetObject(f"{path}/{i}", Sphere(radius), _GLOW)
            self._page.meshcat.SetTransform(f"{path}/{i}", RigidTransform(p_LS))
            shine_through(self._page.meshcat, f"{path}/{i}")
        self._links[link] = False
        self._page.scene.show(path, False, self._page.scene.start)


def draw_end(
    diagram: Diagram, status: MotionStatus, q: np.ndarray, time: float
) -> None:
    """Highlights the link and the point that hold the robot when a run ends.

    Args:
        diagram: A diagram with a `MotionStatusView`.
        status: The robot's state at the end.
        q: The robot's configuration, shape (n_q,) [m, rad].
        time: Time of the end [s].
    """
    diagram.GetSubsystemByName(_NAME).light_up(status, q, time)


def _draw_ring(meshcat: Meshcat):
    angle = np.linspace(0.0, 2.0 * np.pi, 33)
    circle = [np.cos(angle), np.sin(angle), np.zeros_like(angle)]
    vertices, faces = tube_mesh(_RING * np.stack(circle, axis=1), _TUBE)
    meshcat.SetTriangleMesh(f"{PLACE}/ring", vertices.T, faces.T, _AMBER)
    meshcat.SetObject(f"{PLACE}/point", Sphere(2 * _TUBE), _AMBER)
    for name in ("ring", "point"):
        shine_through(meshcat, f"{PLACE}/{name}")
