r"""Estimates a base's pose from its odometry and from a localisation.

The filter estimates X_WO, the pose of the odometry's frame in the map. It
represents the error of the estimate as an error e = (x, y, yaw) of the base's
pose in W. If the base moves by (dx, dy) in W between two odometry messages, the
error's covariance P becomes

    F P F^T + Q,    F = [1 0 -dy; 0 1 dx; 0 0 1],

since an error of the heading rotates the motion. Q is the noise of the
odometry. A fix is a pose from the localisation, with covariance R. It may
arrive late, so the filter stores the odometry and P of the last seconds, and
compares a fix with the estimate for the time at which it was measured. A Kalman
step changes X_WO, and F propagates the decrease of P from that time to the
present.

Errors of a localisation's fixes are correlated, so many fixes are not more
accurate than one. Therefore P only describes how well fixes agree, and P + R is
the covariance of the base's pose.

If a localisation drifts, each fix moves the estimate by a small distance in the
direction of the drift. So the filter also compares a fix with estimates from
some seconds ago, to which only odometry has been added since then. The
difference between these estimates and the present one is added to the bound on
the base's error.

The pose that the controller uses approaches the estimate slowly. The remaining
difference is also added to the bound. So a correction increases the bound at
once, but the pose does not jump.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.wire.localization import BaseFix
from remosplat_drake.robot.planar_pose import (
    composed,
    largest_error,
    odometry_frame,
    relative,
    stepped,
)

GATE = 40.0
"""A fix counts as a jump if its squared Mahalanobis distance from an estimate
exceeds this value. By chance, one of a hundred million correct fixes does so
(chi-squared distribution, 3 degrees of freedom).
"""

MEMORY = 2.0
"""Odometry is stored for this time [s]. A fix that was measured before the
oldest stored odometry is ignored."""

_ANCHOR_PERIOD = 2.0
"""Least time between two stored estimates, with which later fixes are compared
[s]."""

_ANCHORS = 2
"""At most this many estimates are stored for comparison with later fixes."""

_AHEAD = 0.1
"""If a fix is stamped later than the latest odometry, the odometry is
extrapolated by at most this time [s]. Some programs stamp /tf in the future on
purpose.
"""

_WAITING = np.array([1e-3, 1e-3, 5e-4])
"""Standard deviations of the error in x, y and yaw that odometry accumulates in
1 s, even at rest [m, m, rad]."""


@dc.dataclass(frozen=True, eq=False)
class Anchor:
    """An estimate that was stored earlier; later fixes do not change it.

    Attributes:
        stamp: Time at which the estimate was stored [s].
        X_WO: The estimate, shape (3,) [m, m, rad].
        P: Covariance of the base's present x, y, yaw, computed from this
            estimate and the odometry since then, shape (3, 3).
    """

    stamp: float
    X_WO: np.ndarray
    P: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class BaseFilter:
    """Immutable state of the filter, with k stored odometry messages.

    Attributes:
        config: Settings, with the accuracies of localisation and odometry.
        stamp: Stamps of the latest odometry messages, shape (k,) [s].
        X_OB: Poses of the base in these messages, shape (k, 3) [m, m, rad].
        P: Covariance of the base's x, y, yaw in W at each message, without the
            errors that all fixes share, shape (k, 3, 3).
        X_WO: The estimate, shape (3,) [m, m, rad]; None before the first fix.
        in_effect: The X_WO that the controller uses, which approaches the
            estimate slowly, shape (3,) [m, m, rad]; None before the first fix.
        R: Covariance of the latest fix, propagated to the base's present pose,
            shape (3, 3).
        fixed: Stamp of the latest fix that was used [s].
        anchors: Earlier estimates, with which fixes are also compared.
        refusal: Reason why the latest fix was not used; empty if it was used.
    """

    config: LocalizationConfig
    stamp: np.ndarray = dc.field(default_factory=lambda: np.zeros(0))
    X_OB: np.ndarray = dc.field(default_factory=lambda: np.zeros((0, 3)))
    P: np.ndarray = dc.field(default_factory=lambda: np.zeros((0, 3, 3)))
    X_WO: np.ndarray | None = None
    in_effect: np.ndarray | None = None
    R: np.ndarray = dc.field(default_factory=lambda: np.zeros((3, 3)))
    fixed: float = -np.inf
    anchors: tuple[Anchor, ...] = ()
    refusal: str = ""

    def __deepcopy__(self, memo) -> "BaseFilter":
        return self

    def pose(self, X_OB: np.ndarray) -> np.ndarray:
        """Converts X_OB to X_WB, shape (3,); NaN before the first fix."""
        if self.in_effect is None:
            return np.full(3, np.nan)
        return composed(self.in_effect, X_OB)

    @property
    def uncertainty(self) -> np.ndarray:
        """Bounds on errors of the base's position and yaw, (2,) [m, rad]."""
        if self.X_WO is None or self.in_effect is None:
            return np.full(2, np.inf)
        X_OB = self.X_OB[-1]
        X_WB = composed(self.X_WO, X_OB)
        told = composed(self.in_effect, X_OB)
        bound = largest_error(
            self.P[-1] + self.R, self.config.sigmas, X_WB, told
        )
        strays = [
            relative(X_WB, composed(anchor.X_WO, X_OB))
            for anchor in self.anchors
        ]
        sizes = [(np.hypot(x, y), abs(turn)) for x, y, turn in strays]
        return bound + np.max(sizes, axis=0, initial=0.0)


def with_odometry(
    known: BaseFilter, stamp: float, X_OB: np.ndarray
) -> BaseFilter:
    """Returns the filter after another odometry message.

    Args:
        known: The previous filter.
        stamp: Time at which the odometry was measured [s]. A message that is
            not newer than the previous one is ignored.
        X_OB: x, y, yaw of the base by its wheel odometry, shape (3,) [m, m,
            rad].
    """
    if len(known.stamp) and not stamp > known.stamp[-1]:
        return known
    P = np.zeros((3, 3))
    R, in_effect, anchors = known.R, known.in_effect, known.anchors
    if len(known.stamp) and known.X_WO is not None and in_effect is not None:
        seconds = stamp - known.stamp[-1]
        F = _swing(known.X_WO, known.X_OB[-1], X_OB)
        noise = _noise(known.config, known.X_OB[-1], X_OB, seconds)
        P = F @ known.P[-1] @ F.T + noise
        R = F @ R @ F.T
        anchors = tuple(
            dc.replace(anchor, P=F @ anchor.P @ F.T + noise)
            for anchor in anchors
        )
        most = known.config.correction_speed * min(seconds, MEMORY)
        in_effect = stepped(in_effect, composed(known.X_WO, X_OB), X_OB, most)
    first = np.searchsorted(known.stamp, stamp - MEMORY)
    return dc.replace(
        known,
        stamp=np.append(known.stamp[first:], stamp),
        X_OB=np.vstack([known.X_OB[first:], X_OB]),
        P=np.concatenate([known.P[first:], P[None]]),
        R=R,
        in_effect=in_effect,
        anchors=anchors,
    )


def doubted(known: BaseFilter, shift: float, turn: float) -> BaseFilter:
    """Returns the filter after a jump of the odometry, with a larger P.

    Args:
        known: The filter after the odometry message that jumped.
        shift: Distance of the jump [m].
        turn: Angle of the jump [rad].
    """
    P = known.P.copy()
    P[-1] += np.diag(np.square([shift, shift, turn]))
    return dc.replace(known, P=P, anchors=())


def with_fix(known: BaseFilter, fix: BaseFix) -> BaseFilter:
    """Returns the filter after a fix, which may come late.

    Args:
        known: The previous filter, with at least one odometry message.
        fix: The fix. It is ignored if it was measured before the latest fix, or
            before the stored odometry.
    """
    problem = _wrong_frame(known.config, fix)
    if problem:
        return dc.replace(known, refusal=problem)
    i = int(np.searchsorted(known.stamp, fix.stamp, "right")) - 1
    if i < 0 or fix.stamp <= known.fixed:
        return known
    X_OB = _odometry_at(known, fix.stamp, i)
    X_WB = fix.pose
    if _same(fix.child_frame, known.config.odometry_frame):
        X_WB = composed(fix.pose, X_OB)
    config = known.config
    floor = np.square([config.least_shift] * 2 + [config.least_turn])
    R = fix.covariance + np.diag(floor)
    if known.X_WO is None:
        X_WO = odometry_frame(X_WB, X_OB)
        change = R
        known = dc.replace(known, in_effect=X_WO)
    else:
        expected = composed(known.X_WO, X_OB)
        error, S = _error(expected, X_WB), known.P[i] + R
        for anchor in (
            Anchor(fix.stamp, known.X_WO, known.P[i]),
            *known.anchors,
        ):
            off = _error(composed(anchor.X_WO, X_OB), X_WB)
            if not off @ np.linalg.solve(anchor.P + R, off) <= GATE:
                return dc.replace(known, refusal=_jump(off))
        gain = np.linalg.solve(S, known.P[i]).T
        X_WO = odometry_frame(expected + gain @ error, X_OB)
        change = -gain @ known.P[i]
    swings = np.array([_swing(X_WO, X_OB, later) for later in known.X_OB[i:]])
    P = known.P[i:] + swings @ change @ swings.transpose(0, 2, 1)
    return dc.replace(
        known,
        # Later fixes must not be older than this one, so older odometry is
        # removed.
        stamp=known.stamp[i:],
        X_OB=known.X_OB[i:],
        P=P,
        X_WO=X_WO,
        R=swings[-1] @ R @ swings[-1].T,
        fixed=fix.stamp,
        anchors=_with_anchor(known.anchors, Anchor(fix.stamp, X_WO, P[-1])),
        refusal="",
    )


def _with_anchor(
    anchors: tuple[Anchor, ...], estimate: Anchor
) -> tuple[Anchor, ...]:
    """Stores an estimate if a period has passed, and removes the oldest one."""
    if anchors and estimate.stamp - anchors[-1].stamp < _ANCHOR_PERIOD:
        return anchors
    return (*anchors, estimate)[-_ANCHORS:]


def _error(expected: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Difference between a measured and an expected pose in W, shape (3,)."""
    error = measured - expected
    error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
    return error


def _swing(
    X_WO: np.ndarray, X_OB: np.ndarray, X_OB_after: np.ndarray
) -> np.ndarray:
    """Returns the Jacobian F (see the module) of a motion, shape (3, 3)."""
    c, s = np.cos(X_WO[2]), np.sin(X_WO[2])
    x, y = (X_OB_after - X_OB)[:2]
    F = np.eye(3)
    F[:2, 2] = -(s * x + c * y), c * x - s * y
    return F


def _noise(
    config: LocalizationConfig,
    X_OB: np.ndarray,
    X_OB_after: np.ndarray,
    seconds: float,
) -> np.ndarray:
    """Covariance Q of the odometry's noise in a motion, shape (3, 3)."""
    x, y, turn = relative(X_OB, X_OB_after)
    way = np.hypot(x, y)
    moving = [config.odometry_drift**2 * way] * 2
    moving.append(config.odometry_turn**2 * (way + abs(turn)))
    return np.diag(np.array(moving) + _WAITING**2 * seconds)


def _odometry_at(known: BaseFilter, stamp: float, i: int) -> np.ndarray:
    """Interpolates the odometry between messages i and i + 1, shape (3,).

    After the latest message, the last motion is extrapolated.
    """
    later = min(i + 1, len(known.stamp) - 1)
    if later == 0:
        return known.X_OB[0]
    step = relative(known.X_OB[later - 1], known.X_OB[later])
    span = known.stamp[later] - known.stamp[later - 1]
    ahead = min(stamp - known.stamp[i], _AHEAD if later == i else span)
    return composed(known.X_OB[i], ahead / span * step)


def _wrong_frame(config: LocalizationConfig, fix: BaseFix) -> str:
    if not _same(fix.frame, config.map_frame):
        return f"frame_id is {fix.frame!r}, not {config.map_frame!r}"
    valid = (config.base_frame, config.odometry_frame)
    if not any(_same(fix.child_frame, name) for name in valid):
        return f"child_frame_id is {fix.child_frame!r}, not one of {valid}"
    return ""


def _same(frame: str, other: str) -> bool:
    """Whether two names denote one frame; ROS 1 permits a leading slash."""
    return frame.strip("/") == other.strip("/")


def _jump(error: np.ndarray) -> str:
    shift, turn = np.hypot(*error[:2]), np.degrees(abs(error[2]))
    return (
        f"jumped by {1e3 * shift:.0f} mm and {turn:.1f} deg, more than"
        " covariance and odometry explain"
    )
