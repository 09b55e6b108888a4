"""`OperatorCommand`: an operator's requests to the target so far."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class OperatorCommand:
    """One operator's requests to the target; copying returns the object.

    One-time events are counted, and an increased count is a request: no press
    is lost between two reads, and nothing needs a reset. Of several new
    requests, the first one in this order counts: hold, home, pose, scan,
    velocity, moves. A request to hold also ends a job, and other requests are
    ignored during a job. A request applies to the end effector that was chosen
    last. Requests to open or close the hand are independent of these; if the
    hand carries an object, a request to open it lets the object go.

    Attributes:
        source: Name of the device that the operator uses, for display.
        X_WT: Requested pose of the target T in W, shape (4, 4); None before the
            first.
        moves: Number of times that the operator took control of `X_WT`. A
            slider counts each manual change, but not its updates that only
            display the target; a stream of poses counts once, at its start.
        V_W: Requested velocity of the target, angular above translational,
            shape (6,) [rad/s, m/s]; None unless the operator holds the dead-man
            button.
        holds: Number of requests to hold the target.
        homes: Number of requests to go home.
        pose: Name of the latest requested saved pose.
        poses: Number of requests of saved poses.
        scans: Number of requests of a scan.
        opens: Number of requests to open the hand.
        closes: Number of requests to close the hand.
        thing: Name of the object that shall be taken; empty before the first
            request.
        takes: Number of requests to take an object.
        support: Name of the object on which the carried one shall be placed;
            empty before the first request.
        p_WNear: Point near which it shall be placed, shape (3,) [m]; None for
            below the hand.
        places: Number of requests to place the carried object.
        effector: Name of the end effector chosen last; empty for the first or
            only one.
        choices: Number of times that an end effector was chosen.
        trouble: Why `X_WT` must not be followed now; empty if it may be.
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
    effector: str = ""
    choices: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorCommand":
        return self
