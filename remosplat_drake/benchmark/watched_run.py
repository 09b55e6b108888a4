"""`WatchedRun`: finds the causes of contacts if cameras detect the movers.

A robot cannot avoid a mover that comes out of space that no camera sees. If a
link moves towards a mover and touches it, the robot has therefore caused the
contact only if cameras have seen the mover for long enough. This means from a
time at which its distance was at least the protective separation distance, or
from the start.
"""

import dataclasses as dc
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.controller.verification.protective_separation import (
    Monitoring,
    protective_separation,
)
from remosplat_drake.detection.simulated.simulated_detection import PlacedCamera
from remosplat_drake.recording.mover_contacts import (
    TOWARDS,
    UNSEEN,
    Contact,
    MoverJudgement,
)
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers


@dc.dataclass(frozen=True, eq=False)
class WatchedRun:
    """A run, and the cameras that detected movers during the run.

    Attributes:
        robot: The robot.
        trajectory: The robot's motion.
        movers: Function that returns the true movers at a time [s], always in
            the same order.
        cameras: The cameras.
        least_pixels: A mover counts as seen if at least this many pixels show
            it.
        separation: The additional distance C of the protective separation
            distance [m].
        dt: Control period [s].
    """

    robot: RobotModel
    trajectory: Trajectory
    movers: Callable[[float], Movers]
    cameras: Sequence[PlacedCamera]
    least_pixels: int
    separation: float
    dt: float

    def judged(self, judgement: MoverJudgement) -> MoverJudgement:
        """Corrects the cause of contacts with movers that cameras saw too late.

        Args:
            judgement: The contacts, by the motion of the links.
        """
        contacts = (
            dc.replace(contact, kind=UNSEEN)
            if contact.kind == TOWARDS and not self.was_seen(contact)
            else contact
            for contact in judgement.contacts
        )
        return dc.replace(judgement, contacts=tuple(contacts))

    def was_seen(self, contact: Contact) -> bool:
        """Returns whether cameras have seen a mover since it was S_p away.

        S_p is the protective separation distance. If the mover was never so far
        away, cameras must have seen it from the start.

        Args:
            contact: A link and a mover that touched.
        """
        time = self.trajectory.time
        last = int(np.searchsorted(time, contact.start, "right")) - 1
        for k in range(last, -1, -1):
            if not self._is_in_view(k, contact.mover):
                return False
            if self._is_apart(k, contact):
                return True
        return True

    def _is_in_view(self, k: int, mover: str) -> bool:
        """Returns whether any camera sees a mover at a tick."""
        q, time = self.trajectory.q[k], float(self.trajectory.time[k])
        truth, spheres = self.movers(time), self.robot.spheres_at(q)
        names = [m.name for m in truth]
        shots = (
            placed.camera.take(placed.pose(q), time, truth, spheres)
            for placed in self.cameras
        )
        which = names.index(mover)
        return any(s.pixels[which] >= self.least_pixels for s in shots)

    def _is_apart(self, k: int, contact: Contact) -> bool:
        """Returns whether the robot may regard link and mover as S_p apart.

        S_p is the protective separation distance. The mover's state is its true
        state at the time of the newest image that can have arrived by then. It
        is extrapolated with the mover's motion and bounds.
        """
        time, u = float(self.trajectory.time[k]), self.trajectory.u[k]
        late = max(c.period + c.latency for c in self.cameras)
        known = self.movers(max(time - late, 0.0))
        links = np.array(self.robot.spheres.links)
        names = np.array([mover.name for mover in known])
        found = protective_separation(
            self.robot.state(self.trajectory.q[k]),
            known,
            time,
            u,
            Monitoring.make(
                u, self.robot.acceleration_limit, self.dt, self.separation
            ),
            np.zeros(len(links)),
        )
        pair = links[found.sphere] == contact.link
        pair &= names[found.mover] == contact.mover
        return bool((found.margin[pair] >= 0.0).all())
