"""Messages between the control process and the cockpit's process."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.camera.wrist_camera import WristCamera
from remosplat_drake.cockpit.worst_tick import WorstTick
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.task_outline import TaskOutline
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.teleop.teleop_config import TeleopConfig
from remosplat_drake.visualization.page_state import WAITING, PageState


@dc.dataclass(frozen=True, eq=False)
class CockpitJob:
    """The settings that the cockpit's process receives at its start.

    Attributes:
        title: Title of the page: the scenario's name.
        host: Network interface that the page is served on.
        port: TCP port of the page; None means the first free port.
        robot: The robot.
        planner: The planner, which searches for configurations that reach a
            target.
        stopping: Distance that the robot keeps from the scene [m].
        influence: Influence distance of the controller, beyond which it ignores
            obstacles [m].
        control_period: Time between two control ticks [s].
        config: Settings of the teleoperation, with the workspace and the saved
            poses.
        q0: Configuration at the start, shape (n_q,).
        X_EC: Pose of the wrist camera in the end effector's frame, shape (4,
            4); None without a camera there.
        mapping: Whether there is a live map.
        scenes: The scenes that a simulated camera can show; it shows the first
            scene at the start.
        make_camera: Function that makes the wrist camera; None without a wrist
            camera.
        truth: The true scene, which is drawn if the scenario has no splat; else
            None.
    """

    title: str
    host: str
    port: int | None
    robot: RobotModel
    planner: MotionPlanner
    stopping: float
    influence: float
    control_period: float
    config: TeleopConfig
    q0: np.ndarray
    mapping: bool
    scenes: tuple[PrimitiveScene, ...] = ()
    make_camera: Callable[[], WristCamera] | None = None
    X_EC: np.ndarray | None = None
    truth: PrimitiveScene | None = None


@dc.dataclass(frozen=True, eq=False)
class MapPicture:
    """A map that the cockpit draws, and in which it tests targets.

    Attributes:
        field: The distance field.
        splat_W: The splat in W; None if the map has no splat.
        coverage: The space that cameras have seen; None if it is unknown.
        shows_unseen: Whether the boundary of unseen space is drawn at first.
        X_WG: Pose of the coverage's grid in W, shape (4, 4).
    """

    field: DistanceField
    splat_W: GaussianSplat | None
    coverage: Coverage | None
    shows_unseen: bool
    X_WG: np.ndarray = dc.field(default_factory=lambda: np.eye(4))


@dc.dataclass(frozen=True, eq=False)
class PageContent:
    """The content of the page at one moment.

    Attributes:
        time: Time of the diagram [s].
        q: The measured configuration, shape (n_q,).
        X_WE: Pose of the end effector that the operator moves, shape (4, 4).
        X_WB: Pose of the base, shape (4, 4).
        X_WT: Pose of the target of that end effector, shape (4, 4).
        is_followed: Whether the target moves to the pose that the operator has
            set on the page.
        state: Description of the robot's state, and the buttons that have an
            effect now.
        held_link: Name of the link that an obstacle or a limit holds, or that a
            stop concerns; empty if there is none.
        cause: The cause that holds the robot, one of `motion_status.CAUSES`;
            empty if nothing holds it.
        p_WHeld: Point at which an obstacle holds the robot, or that a stop
            concerns, shape (3,) [m]; None if there is none.
        target: Description of the target's state.
        map: Description of the map's state.
        trouble: Reason why the page's STOP does not work; empty while it works.
        worst: Smallest clearance and longest duration of the control ticks
            since the previous content; None if there was no tick.
        effector: Index of the end effector that the operator moves.
        X_WTs: Poses of the targets of all e end effectors, shape (e, 4, 4);
            None if the robot has only one end effector.
        outline: The operator's jobs with objects.
        objects: The objects at their present poses.
    """

    time: float
    q: np.ndarray
    X_WE: np.ndarray
    X_WB: np.ndarray
    X_WT: np.ndarray
    is_followed: bool = False
    state: PageState = dc.field(
        default_factory=lambda: PageState(WAITING, "Starting")
    )
    held_link: str = ""
    cause: str = ""
    p_WHeld: np.ndarray | None = None
    target: str = ""
    map: str = ""
    trouble: str = ""
    worst: WorstTick | None = None
    effector: int = 0
    X_WTs: np.ndarray | None = None
    outline: TaskOutline = dc.field(default_factory=TaskOutline)
    objects: tuple[SceneObject, ...] = ()

    def after(self, earlier: "PageContent | None") -> "PageContent":
        """Returns this content, merged with the worst tick of skipped content.

        Args:
            earlier: The previous content if the page has not received it; else
                None.
        """
        if earlier is None or earlier.worst is None:
            return self
        return dc.replace(self, worst=earlier.worst.or_of(self.worst))


@dc.dataclass(frozen=True, eq=False)
class CockpitRequests:
    """All requests so far of the people who use the cockpit.

    Attributes:
        command: The operator's command for the target.
        map_requests: The operator's requests to the map.
        scene_changes: Number of requests to switch a simulated camera to its
            next scene.
        operator: Numbers of presses of STOP (by all clients) and of RELEASE (by
            the operator).
    """

    command: OperatorCommand = dc.field(default_factory=OperatorCommand)
    map_requests: MapRequests = dc.field(default_factory=MapRequests)
    scene_changes: int = 0
    operator: OperatorRequests = dc.field(default_factory=OperatorRequests)


@dc.dataclass(frozen=True)
class Serving:
    """Message: the page can be opened.

    Attributes:
        url: Address of the page.
    """

    url: str


@dc.dataclass(frozen=True)
class CodeIssued:
    """Message: a new code; the client that types it operates the robot.

    Attributes:
        code: The code, for the terminal.
        why: Reason for the new code; empty for the first code.
    """

    code: str
    why: str = ""


@dc.dataclass(frozen=True)
class Failed:
    """Message: the page cannot be served.

    Attributes:
        reason: The reason, in one line.
    """

    reason: str


@dc.dataclass(frozen=True)
class Beat:
    """Message: the process is alive, and its page answers."""
