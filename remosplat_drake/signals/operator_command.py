"""`OperatorCommand`: an operator's requests that concern the target."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class OperatorCommand:
    """Requests of one operator so far; copying returns the object itself.

    Button presses and similar events are counted, and an increased count is a
    request. So no press is lost between two reads, and no flag must be reset.
    If there are several new requests, the first one in this order is used:
    hold, home, pose, scan, velocity, moves. A job is a request to find, to take
    or to place an object. A request to hold also ends a job; all other requests
    are ignored during a job. A request applies to the end effector that was
    chosen last. Requests to open or close the hand are independent of the other
    requests. If the hand carries an object, a request to open the hand releases
    the object.

    Attributes:
        source: Name of the device that the operator uses, for display.
        X_WT: Requested pose of the target T in W, shape (4, 4); None before the
            first request.
        moves: Number of times that the operator took control of `X_WT`. Each
            manual change of a slider is counted, but not updates of the slider
            that only display the target. A stream of poses is counted once, at
            its start.
        V_W: Requested velocity of the target, angular before translational,
            shape (6,) [rad/s, m/s]; None if the operator does not press the
            dead-man button.
        holds: Number of requests to hold the target.
        homes: Number of requests to go home.
        pose: Name of the latest requested saved pose.
        poses: Number of requests of saved poses.
        scans: Number of requests of a scan.
        opens: Number of requests to open the hand.
        closes: Number of requests to close the hand.
        thing: Name of the object to take; empty before the first request.
        takes: Number of requests to take an object.
        support: Name of the object on which to place the carried object; empty
            before the first request.
        p_WNear: Point in W near which to place the carried object, shape (3,)
            [m]; None to place it below the hand.
        places: Number of requests to place the carried object.
        p_WFind: Point in W on an object of the map, shape (3,) [m]; None before
            the first request to find one.
        finds: Number of requests to find an object in the map.
        effector: Name of the end effector that was chosen last; empty for the
            first or only one.
        choices: Number of times that an end effector was chosen.
        trouble: Reason why the target must not follow `X_WT` now; empty if it
            may.
    """

    source: str = ""
    X_WT: np.ndarray | None = None
    moves: int = 0
    V_W: np.ndarray | None = None
    holds: int = 0
    homes: int = 0
    pose: str = ""
    poses: int = 0
    scans: int = 0
    opens: int = 0
    closes: int = 0
    thing: str = ""
    takes: int = 0
    support: str = ""
    p_WNear: np.ndarray | None = None
    places: int = 0
    p_WFind: np.ndarray | None = None
    finds: int = 0
    effector: str = ""
    choices: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorCommand":
        return self
