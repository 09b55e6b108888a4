"""`OperatorInput`: stores the requests of people who use the cockpit."""

import dataclasses as dc
from collections.abc import Callable
from threading import Lock
from time import monotonic

import numpy as np

from remosplat_drake.cockpit.messages import CockpitRequests
from remosplat_drake.teleop.gamepad import SILENCE

SOURCE = "cockpit"
"""Name of the operator's device."""


class OperatorInput:
    """Counts presses of buttons, and stores the operator's desired pose.

    It is thread-safe, since callbacks of the page run in several threads.

    Args:
        changed: Function that is called after each new request, in the thread
            of the page's callback, with all requests so far.
    """

    def __init__(self, changed: Callable[[CockpitRequests], None]):
        requests = CockpitRequests()
        command = dc.replace(requests.command, source=SOURCE)
        self._requests = dc.replace(requests, command=command)
        self._changed = changed
        self._lock = Lock()
        self._led_at = -np.inf

    @property
    def requests(self) -> CockpitRequests:
        """All requests so far."""
        return self._requests

    @property
    def X_WT(self) -> np.ndarray | None:
        """Latest desired pose, shape (4, 4); None before the first request."""
        return self._requests.command.X_WT

    def move(self, X_WT: np.ndarray) -> None:
        """Requests a pose of the target.

        Args:
            X_WT: The pose, shape (4, 4); values that are not finite are
                ignored.
        """
        if np.isfinite(X_WT).all():
            self._count("command", "moves", X_WT=np.array(X_WT, float))

    def press(self, name: str) -> None:
        """Counts a press of a button for the target.

        Args:
            name: Name of the count in `OperatorCommand`: holds, homes, scans,
                opens or closes.
        """
        self._count("command", name)

    def lead(self, V_W: np.ndarray | None) -> None:
        """Requests a velocity of the target; the request expires by itself.

        Args:
            V_W: The velocity, angular above translational, shape (6,) [rad/s,
                m/s]; None if the dead-man switch is not held.
        """
        with self._lock:
            self._led_at = monotonic()
            command = self._requests.command
            if V_W is not None or command.V_W is not None:
                command = dc.replace(command, V_W=V_W)
                self._tell(dc.replace(self._requests, command=command))

    def expire(self) -> None:
        """Ends the requested velocity if it was not renewed for `SILENCE`."""
        is_led = self._requests.command.V_W is not None
        if is_led and monotonic() - self._led_at > SILENCE:
            self.lead(None)

    def let_go(self) -> None:
        """Requests that the target stays in place.

        The page calls this when no client operates the robot any more.
        """
        self.lead(None)
        self.press("holds")

    def choose(self, effector: str) -> None:
        """Selects the end effector that the operator moves from now on.

        The pose that was requested for the previous end effector is dropped.

        Args:
            effector: Name of the end effector.
        """
        self._count("command", "choices", effector=effector, X_WT=None)

    def pick(self, pose: str) -> None:
        """Requests a saved pose, given its name."""
        self._count("command", "poses", pose=pose)

    def take(self, thing: str) -> None:
        """Requests to take an object, given its name."""
        self._count("command", "takes", thing=thing)

    def place(self, support: str, p_WNear: np.ndarray | None) -> None:
        """Requests to place the carried object.

        Args:
            support: Name of the object on which the carried object shall stand.
            p_WNear: Point near which it shall stand, shape (3,) [m]; None for
                the place below the hand.
        """
        self._count("command", "places", support=support, p_WNear=p_WNear)

    def find(self, p_W: np.ndarray) -> None:
        """Requests to find the object at a point of the map.

        Args:
            p_W: A point on the object, shape (3,) [m].
        """
        self._count("command", "finds", p_WFind=p_W)

    def request(self, name: str) -> None:
        """Counts a press of a button for the map.

        Args:
            name: Name of the count in `MapRequests`: frames, refines, undos or
                saves.
        """
        self._count("map_requests", name)

    def change_scene(self) -> None:
        """Requests the next scene for a simulated camera."""
        with self._lock:
            changes = self._requests.scene_changes + 1
            self._tell(dc.replace(self._requests, scene_changes=changes))

    def stop(self) -> None:
        """Counts a press of STOP."""
        self._count("operator", "stops")

    def release(self) -> None:
        """Counts a press of RELEASE."""
        self._count("operator", "releases")

    def _count(self, part: str, name: str, **changes) -> None:
        with self._lock:
            before = getattr(self._requests, part)
            changes[name] = getattr(before, name) + 1
            after = dc.replace(before, **changes)
            self._tell(dc.replace(self._requests, **{part: after}))

    def _tell(self, requests: CockpitRequests) -> None:
        self._requests = requests
        self._changed(requests)
