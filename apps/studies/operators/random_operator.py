"""`RandomOperator`: an operator with random requests at random times."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.teleop_config import SavedPose

_ACTS = {
    "wish": 0.42,
    "push": 0.25,
    "pick": 0.08,
    "hold": 0.04,
    "home": 0.04,
    "frame": 0.07,
    "scan": 0.02,
    "refine": 0.01,
    "undo": 0.03,
    "scene": 0.04,
}
"""Acts of the operator and their relative frequencies."""

_PAUSE = 2.0
"""Mean time between two acts [s]."""

_PUSH = (1.0, 4.0)
"""Shortest and longest push of a stick [s]."""

_LOWER, _UPPER = np.array([0.2, -1.1, 0.1]), np.array([2.0, 1.4, 1.3])
"""Bounds of targets in W that are outside of objects [m]."""

_TILT = 50.0
"""Spread of roll and pitch about a gripper that points down [deg]."""

_ROOM = 0.05
"""Objects are placed at least this far from the robot [m]."""

_PATIENCE = 30.0
"""If there is no first map after this time, the operator starts another scan
[s]."""

_HELPLESS = 4.0
"""If the robot is stopped for this time, the operator acts [s]."""


@dc.dataclass(frozen=True, eq=False)
class Look:
    """The data that an operator sees at a time.

    Attributes:
        time: Present time [s].
        stopped: Time for which the robot has been stopped [s].
        is_scanning: Whether a scan is in progress.
        parent: Version of the map that an undo goes back to; None for none.
        spheres: Spheres of the robot at present.
    """

    time: float
    stopped: float
    is_scanning: bool
    parent: int | None
    spheres: Spheres


class RandomOperator:
    """Draws the next act; equal seeds and `Look`s give equal acts.

    It begins with a scan, and waits for its end. Later it requests poses in the
    furniture and elsewhere, pushes a stick, selects saved poses, holds, and
    changes the map and the scene.

    Attributes:
        command: Operator's command: all requests to the target so far.
        map_requests: Requests to the map so far.
    """

    def __init__(
        self,
        seed: int,
        poses: Sequence[str],
        scenes: Sequence[PrimitiveScene],
    ):
        """Prepares the operator.

        Args:
            seed: Seed of all random numbers.
            poses: Names of the saved poses.
            scenes: The scene at first, and those that take turns with it.
        """
        self._rng = np.random.default_rng(seed)
        self._poses = list(poses)
        self._scenes = list(scenes)
        self._shown = 0
        self._let_go = np.inf
        self._tried = 0.0
        self._scanned = -np.inf
        self._next = 0.5
        self.command = OperatorCommand(source="random operator")
        self.map_requests = MapRequests()

    def look(self, look: Look) -> None:
        """Processes a `Look` and carries out the acts that are due."""
        if look.time >= self._let_go:
            self._let_go = np.inf
            self.command = dc.replace(self.command, V_W=None)
        if look.stopped > 0:
            self._tried = max(self._tried, look.time - look.stopped)
            if look.time - self._tried > _HELPLESS:
                self._tried = look.time
                self._act(str(self._rng.choice(["frame", "undo"])), look)
            return
        if look.time < self._next:
            return
        self._next = look.time + self._rng.exponential(_PAUSE)
        if look.parent is None:
            # There is no map yet: it waits for the first scan.
            if look.time > self._scanned + _PATIENCE:
                self._scanned = look.time
                self._act("scan", look)
        elif not look.is_scanning or self._rng.random() < 0.05:
            names = list(_ACTS)
            weights = np.array(list(_ACTS.values()))
            act = self._rng.choice(names, p=weights / weights.sum())
            self._act(str(act), look)

    def _act(self, act: str, look: Look) -> None:
        command = self.command
        match act:
            case "wish":
                self._say(X_WT=self._pose(), moves=command.moves + 1)
            case "push":
                self._say(V_W=self._push())
                self._let_go = look.time + self._rng.uniform(*_PUSH)
            case "pick":
                pose = str(self._rng.choice(self._poses))
                self._say(pose=pose, poses=command.poses + 1)
            case "hold" | "home" | "scan":
                self._say(**{f"{act}s": getattr(command, f"{act}s") + 1})
            case "frame":
                self._ask(MapRequests(frames=1))
            case "refine":
                self._ask(MapRequests(refines=1))
            case "undo":
                # Without any map, the session could not continue.
                if look.parent:
                    self._ask(MapRequests(undos=1))
            case "scene":
                self._change_scene(look)

    def _say(self, **changes) -> None:
        self.command = dc.replace(self.command, **changes)

    def _ask(self, more: MapRequests) -> None:
        self.map_requests += more

    def _pose(self) -> np.ndarray:
        """Draws a target pose; half of them are inside of objects."""
        p_W = self._rng.uniform(_LOWER, _UPPER)
        if self._rng.random() < 0.5:
            things = self._scenes[self._shown].primitives
            thing = things[self._rng.integers(len(things))]
            inside = np.clip(thing.X_WP.translation(), _LOWER, _UPPER)
            p_W = inside + self._rng.normal(size=3) * 0.15
        tilt = self._rng.normal(size=2) * _TILT / 2
        yaw = self._rng.uniform(-180, 180)
        rpy_deg = [180 + tilt[0], tilt[1], yaw]
        return SavedPose(p_W.tolist(), rpy_deg).matrix()

    def _push(self) -> np.ndarray:
        """Draws a twist like that of a gamepad's sticks."""
        V_W = np.zeros(6)
        V_W[3:] = self._rng.uniform(-0.15, 0.15, 3)
        if self._rng.random() < 0.3:
            V_W[:3] = self._rng.uniform(-0.6, 0.6, 3)
        return V_W

    def _change_scene(self, look: Look) -> None:
        """Adds or removes an object, but adds none inside the robot."""
        if len(self._scenes) < 2:
            return
        shown = (self._shown + 1) % len(self._scenes)
        now, then = (
            SignedDistanceField(self._scenes[i]).clearances(look.spheres)
            for i in (self._shown, shown)
        )
        if then.minimum() < min(_ROOM, now.minimum()):
            return
        self._shown = shown
        self._ask(MapRequests(scene=self._scenes[shown]))
