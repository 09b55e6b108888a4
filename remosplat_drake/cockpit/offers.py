"""Finds alternatives to a target that the robot cannot reach."""

import dataclasses as dc
from collections.abc import Callable
from time import monotonic

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.motion_status import (
    HELD,
    MOVING,
    NO_COMMAND,
    NO_PATH,
    NOT_OBEYED,
    MotionStatus,
)
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.thing import UNSEEN_SPACE

OTHER_SIDE = "From the other side"
"""Label of an alternative target at the same position, with the hand turned
about its z axis."""
BACK_OFF = "Back off"
"""Label of an alternative target with the same orientation, further back along
the hand's z axis."""
HIGHER = "Higher"
"""Label of an alternative target with the same orientation, further up."""
NEARER = "Nearer to the robot"
"""Label of an alternative target with the same orientation, nearer to the
position of the hand when the arm is in its home posture."""
LOOK_THERE = "Look there"
"""Label of an alternative target from which the wrist camera sees the unseen
space that stops the robot."""

LABELS = (OTHER_SIDE, BACK_OFF, HIGHER, NEARER, LOOK_THERE)
"""Labels of all alternative targets (offers), in their order on the page."""

_TURNS = (180.0, 90.0, -90.0)
"""Angles by which the hand is turned about its z axis [deg]."""

_STEPS = (0.03, 0.06, 0.1, 0.15, 0.25)
"""Distances by which a target is moved [m]."""

_SHARES = (0.9, 0.75, 0.5, 0.25, 0.1, 0.0, -0.2)
"""Positions on the straight line from the hand in the home posture (0) to the
target (1). The negative position moves the hand away from the target, as is
necessary beside a wall."""

_LOOKS = (0.0, 0.1, 0.2, 0.3)
"""Distances by which the camera is moved up and back, to see a point [m]."""

SETTLES = 0.3
"""Time for which a situation must remain unchanged before targets are tested
[s]. While an operator drags the target, the situation changes all the time."""


@dc.dataclass(frozen=True, eq=False)
class Offer:
    """An alternative to a target that the robot cannot reach.

    Attributes:
        label: One of `LABELS`.
        X_WT: The target, shape (4, 4).
    """

    label: str
    X_WT: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class Trouble:
    """The situation for which alternative targets are searched.

    Attributes:
        X_WT: The operator's target, shape (4, 4).
        X_WE: Pose of the end effector, shape (4, 4).
        p_WHome: Position of the end effector with the arm in its home posture
            and the base at its present pose, shape (3,) [m].
        p_WUnseen: Point of unseen space that is in the way, shape (3,) [m];
            None if another obstacle is in the way.
        X_EC: Pose of the wrist camera in the end effector's frame, shape (4,
            4); None without a wrist camera.
        is_cut_off: Whether no path leads to the target. Targets beside it are
            then not offered, since no path leads to them either.
    """

    X_WT: np.ndarray
    X_WE: np.ndarray
    p_WHome: np.ndarray
    p_WUnseen: np.ndarray | None = None
    X_EC: np.ndarray | None = None
    is_cut_off: bool = False

    def is_like(self, other: "Trouble | None") -> bool:
        """Returns whether the same offers apply to another situation.

        The same offers apply if the target and the kind of the obstacle are the
        same; the hand may have moved.

        Args:
            other: Another situation, or None.
        """
        if other is None or not np.array_equal(self.X_WT, other.X_WT):
            return False
        same = (self.p_WUnseen is None) == (other.p_WUnseen is None)
        return same and self.is_cut_off == other.is_cut_off


class OfferSearch:
    """Searches for alternative targets (offers); a step tests one target.

    The search pauses between two tests for as long as the last test took, so
    that the process has time for its other work.

    Args:
        clock: Function that returns the time [s].

    Attributes:
        offers: The offers so far, at most one of each label.
    """

    def __init__(self, clock: Callable[[], float] = monotonic):
        self._clock, self._due = clock, -np.inf
        self._begun = -np.inf
        self.offers: tuple[Offer, ...] = ()
        self._trouble: Trouble | None = None
        self._field: object = None
        self._left: list[Offer] = []

    def begin(self, trouble: Trouble | None, field: object) -> None:
        """Starts a new search if the situation or the map has changed.

        Args:
            trouble: The situation; None if no offer is needed.
            field: The map.
        """
        known = self._trouble
        is_same = known is trouble or (trouble and trouble.is_like(known))
        if is_same and field is self._field:
            return
        self._trouble, self._field, self.offers = trouble, field, ()
        self._left = []
        if trouble is not None:
            self._left = [Offer(*one) for one in candidates(trouble)]
        self._due = self._clock() + SETTLES

    @property
    def is_busy(self) -> bool:
        """Whether further targets must be tested."""
        return bool(self._left)

    def step(self, works: Callable[[np.ndarray], bool]) -> None:
        """Tests a target, if any is left and the pause between tests is over.

        Args:
            works: Function that returns whether the robot can reach a target.
        """
        test = self.next_test()
        if test is not None:
            self.judge(test, works(test.X_WT))

    def next_test(self) -> Offer | None:
        """Returns a target to test; None if none is left or during a pause.

        The caller tests it, and passes the result to `judge`.
        """
        if not self._left or self._clock() < self._due:
            return None
        self._begun = self._clock()
        return self._left[0]

    def judge(self, test: Offer, works: bool) -> None:
        """Stores the result of a test; ignores it if the situation has changed.

        Args:
            test: The tested target.
            works: Whether the robot can reach the target.
        """
        now = self._clock()
        self._due = max(self._due, now + (now - self._begun))
        if test not in self._left:
            return
        self._left.remove(test)
        if works:
            self.offers += (test,)
            self._left = [o for o in self._left if o.label != test.label]


def candidates(trouble: Trouble) -> list[tuple[str, np.ndarray]]:
    """Returns targets to test, with labels; the smallest changes come first.

    Args:
        trouble: The situation.
    """
    X_WT = trouble.X_WT
    found = []
    if trouble.p_WUnseen is not None and trouble.X_EC is not None:
        found += [
            (LOOK_THERE, _looking(trouble, trouble.p_WUnseen, trouble.X_EC, by))
            for by in _LOOKS
        ]
    if not trouble.is_cut_off:
        up = np.array([0.0, 0.0, 1.0])
        found += [(OTHER_SIDE, X_WT @ _about_z(angle)) for angle in _TURNS]
        found += [(BACK_OFF, _moved(X_WT, -by * X_WT[:3, 2])) for by in _STEPS]
        found += [(HIGHER, _moved(X_WT, by * up)) for by in _STEPS]
    way = X_WT[:3, 3] - trouble.p_WHome
    found += [(NEARER, _moved(X_WT, (share - 1.0) * way)) for share in _SHARES]
    return found


def trouble_of(
    status: MotionStatus,
    target: Target,
    robot: RobotModel,
    q: np.ndarray,
    X_EC: np.ndarray | None = None,
) -> Trouble | None:
    """Returns the situation of a robot that is kept from its target.

    Args:
        status: The robot's state.
        target: The present target.
        robot: The robot, with one end effector.
        q: The robot's configuration, shape (n_q,) [rad, m].
        X_EC: Pose of its wrist camera in the end effector's frame, shape (4,
            4); None if no frame of this camera can be added to the map.

    Returns:
        The situation; None if other targets would not help, for example while
        the robot moves freely, waits for a mover, or is stopped.
    """
    is_held = status.kind in (HELD, MOVING) and status.cause
    if not is_held or status.cause in (MOVER, NO_COMMAND, NOT_OBEYED):
        return None
    return Trouble(
        target.X_WT,
        robot.end_effector_pose(q),
        place_at_home(robot, q),
        status.p_W if status.thing == UNSEEN_SPACE.name else None,
        X_EC,
        status.cause == NO_PATH,
    )


def place_at_home(
    robot: RobotModel, q: np.ndarray, effector: int = 0
) -> np.ndarray:
    """Returns a hand's position with the arm at home, shape (3,) [m].

    Args:
        robot: The robot.
        q: The robot's configuration, from which only the pose of the base is
            used, shape (n_q,).
        effector: Index of the end effector.
    """
    home = robot.q_home.copy()
    arm = robot.n_q - len(robot.home)
    home[:arm] = q[:arm]
    return robot.end_effector_pose(home, effector)[:3, 3]


def _about_z(angle: float) -> np.ndarray:
    turn = RollPitchYaw([0.0, 0.0, np.radians(angle)])
    return RigidTransform(turn, np.zeros(3)).GetAsMatrix4()


def _moved(X_WT: np.ndarray, by_W: np.ndarray) -> np.ndarray:
    X_WT = X_WT.copy()
    X_WT[:3, 3] += by_W
    return X_WT


def _looking(
    trouble: Trouble, p_W: np.ndarray, X_EC: np.ndarray, by: float
) -> np.ndarray:
    """Returns a target at which the camera, moved up and back, sees a point."""
    p_WC = (trouble.X_WE @ X_EC)[:3, 3]
    away = p_WC - p_W
    away[2] = 0.0
    away /= max(float(np.linalg.norm(away)), 1e-6)
    X_WC = look_at(p_WC + by * (away + np.array([0, 0, 1])), p_W)
    return X_WC.GetAsMatrix4() @ np.linalg.inv(X_EC)
