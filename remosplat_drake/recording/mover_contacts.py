"""Finds true contacts with movers, and classifies them by cause.

A mover may touch a robot that is at rest or that moves away. But a robot must
not move towards a person and touch them.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import MoverArrays, Movers

TOWARDS, RETREATING, RESTING = "towards", "retreating", "resting"
"""Kinds of contact. The link moves towards the mover, so that the contact is
the robot's fault; it moves away or sideways; or it is at rest."""

UNSEEN = "unseen"
"""Kind of contact: the link moved towards a mover that came out of unseen
space. Evaluations with cameras use it in place of TOWARDS."""

KINDS = (TOWARDS, UNSEEN, RETREATING, RESTING)
"""All kinds of contact, the worst first."""

_MOTIONS = (TOWARDS, RETREATING, RESTING)

LEAST_SPEED = 1e-3
"""A sphere counts as at rest if its speed is at most this value [m/s]."""

WAITING_SPEED = 0.01
"""The robot counts as waiting if its fastest sphere is slower than this
[m/s]."""

SHORTEST = 5e-4
"""Two samples are at least this time apart [s]."""


@dc.dataclass(frozen=True)
class Contact:
    """A contact between a link and a mover (moving object).

    Attributes:
        start: Time of the first touch [s].
        end: Time of the last touch [s].
        link: Name of the link.
        mover: Name of the mover.
        kind: The worst of `KINDS` during the contact.
        depth: Largest penetration [m].
    """

    start: float
    end: float
    link: str
    mover: str
    kind: str
    depth: float


@dc.dataclass(frozen=True, eq=False)
class MoverJudgement:
    """Contacts and distances between a robot and movers in a run.

    Attributes:
        contacts: All contacts, in the order in which they began.
        distance: Least true distance of the robot to any mover at each tick
            and at the end, shape (T + 1,) [m]; infinite without movers.
        waited: Time in which no part of the robot moved [s].
    """

    contacts: tuple[Contact, ...]
    distance: np.ndarray
    waited: float

    def count(self, kind: str) -> int:
        """Returns the number of contacts of one of `KINDS`."""
        return sum(contact.kind == kind for contact in self.contacts)

    @property
    def worst(self) -> str:
        """The worst kind of contact; empty without any."""
        return next((kind for kind in KINDS if self.count(kind)), "")


@dc.dataclass(frozen=True, eq=False)
class _Look:
    """A sample of robot and movers at one time.

    Attributes:
        time: Time of the sample [s].
        p_WS: Centres of n spheres in W, shape (n, 3) [m].
        p_WM: Origins of k movers in W, shape (k, 3) [m].
        distance: Distances between the surfaces of movers and spheres, shape
            (k, n) [m].
        towards_W: Unit vectors from spheres to movers, shape (k, n, 3).
        stretch: Largest distance of a mover's points from its origin, shape
            (k,) [m].
        R_WM: The movers' orientations, shape (k, 3, 3).
        names: The movers' names.
    """

    time: float
    p_WS: np.ndarray
    p_WM: np.ndarray
    distance: np.ndarray
    towards_W: np.ndarray
    stretch: np.ndarray
    R_WM: np.ndarray
    names: tuple[str, ...]


def judge_movers(
    robot: RobotModel,
    time: np.ndarray,
    q: np.ndarray,
    movers: Callable[[float], Movers],
    dt: float,
) -> MoverJudgement:
    """Finds a run's contacts with movers, using their true positions.

    The function samples each tick, and halves the time between two samples
    until a contact is excluded or its start is found. Let d0 and d1 be the
    distances of two surfaces at two samples, and s a bound of their relative
    motion between the samples. The surfaces do not touch between the samples if
    d0 + d1 > s.

    Args:
        robot: The robot, for its spheres.
        time: Times of T ticks [s].
        q: Configurations at the ticks and at the end, shape (T + 1, n_q);
            between two ticks, the configuration is interpolated linearly.
        movers: Function that returns the movers at any time [s]. The movers and
            their order must not change.
        dt: Control period [s].
    """
    judge, contacts = _Judge(robot, movers), _Contacts(robot)
    ticks = np.append(time, time[-1] + dt) if len(time) else np.zeros(1)
    latest = judge.look(ticks[0], q[0])
    contacts.add(latest)
    distance = [latest.distance.min(initial=np.inf)]
    waited = 0.0
    for k in range(len(time)):
        looks = judge.fill(ticks, q, k, latest)
        for look in looks:
            contacts.add(look)
        start, latest = latest, looks[-1]
        moved = np.linalg.norm(latest.p_WS - start.p_WS, axis=1).max()
        waited += dt if moved <= WAITING_SPEED * dt else 0.0
        distance.append(latest.distance.min(initial=np.inf))
    return MoverJudgement(contacts.all(), np.array(distance), waited)


class _Judge:
    """Samples robot and movers at any time of a run."""

    def __init__(self, robot: RobotModel, movers: Callable[[float], Movers]):
        self._robot, self._movers = robot, movers

    def look(self, time: float, q: np.ndarray) -> _Look:
        """Samples robot and movers at a time."""
        spheres = self._robot.spheres_at(q)
        movers = self._movers(time)
        at = movers.at(movers.stamp)
        distance, towards_W = distances(at, spheres.p_WS, spheres.radius)
        return _Look(
            time,
            np.array(spheres.p_WS),
            at.p_WM,
            distance,
            towards_W,
            np.linalg.norm(at.half_extents, axis=1),
            at.R_WM,
            tuple(mover.name for mover in movers),
        )

    def fill(
        self, ticks: np.ndarray, q: np.ndarray, k: int, before: _Look
    ) -> list[_Look]:
        """Samples tick k as densely as necessary to miss no contact.

        Args:
            ticks: Times of the ticks, shape (T,) [s].
            q: Configurations at the ticks, shape (T, n_q).
            k: Index of the tick.
            before: The sample at the tick's beginning.

        Returns:
            The samples after `before`, in the order of their times.
        """

        def at(time: float) -> _Look:
            x = (time - ticks[k]) / (ticks[k + 1] - ticks[k])
            return self.look(time, q[k] + x * (q[k + 1] - q[k]))

        return _between(before, at(ticks[k + 1]), at)


def _between(
    before: _Look, after: _Look, at: Callable[[float], _Look]
) -> list[_Look]:
    """Returns samples after `before` up to `after`, as dense as necessary."""
    if after.time - before.time <= SHORTEST or _is_known(before, after):
        return [after]
    middle = at(0.5 * (before.time + after.time))
    return [*_between(before, middle, at), *_between(middle, after, at)]


def _is_known(before: _Look, after: _Look) -> bool:
    """Whether each pair of surfaces touches all the time, or never."""
    if not before.distance.size:
        return True
    sphere = np.linalg.norm(after.p_WS - before.p_WS, axis=1)
    shift = np.linalg.norm(after.p_WM - before.p_WM, axis=1)
    # |R - I| = sqrt(8) sin(a / 2) for a rotation R by an angle a.
    off = np.linalg.norm(after.R_WM - before.R_WM, axis=(1, 2))
    turn = 2.0 * np.arcsin(np.minimum(off / np.sqrt(8.0), 1.0))
    travel = sphere[None, :] + (shift + turn * before.stretch)[:, None]
    # The arc is slightly longer than the chord.
    clear = before.distance + after.distance > 1.1 * travel
    touching = np.maximum(before.distance, after.distance) < 0.0
    return bool((clear | touching).all())


def distances(
    movers: MoverArrays, p_WS: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the distances between spheres and movers.

    Args:
        movers: k movers.
        p_WS: Centres of n spheres in W, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].

    Returns:
        Signed distances between the surfaces of movers and spheres, shape (k,
        n) [m], and unit vectors from the spheres to the movers' nearest points
        in W, shape (k, n, 3). If a centre is inside a mover's core (its inner
        box), the distance is that to the nearest face, and the vector points
        inwards.
    """
    p_WS = np.asarray(p_WS, float)
    p_MS = np.einsum("kji,knj->kni", movers.R_WM, p_WS - movers.p_WM[:, None])
    size = movers.half_extents[:, None]
    out = np.abs(p_MS) - size
    sign = np.where(p_MS >= 0.0, 1.0, -1.0)
    outside = np.maximum(out, 0.0) * sign
    far = np.linalg.norm(outside, axis=2)
    face = np.take_along_axis(
        np.eye(3)[None], out.argmax(axis=2, keepdims=True), axis=1
    )
    inside = far == 0.0
    away_M = np.where(
        inside[..., None],
        sign * face,
        outside / np.where(inside, 1.0, far)[..., None],
    )
    depth = np.where(inside, out.max(axis=2, initial=-np.inf), far)
    distance = depth - movers.radius[:, None] - np.asarray(radius)[None, :]
    return distance, -np.einsum("kij,knj->kni", movers.R_WM, away_M)


class _Contacts:
    """Contacts of links and movers, updated sample by sample."""

    def __init__(self, robot: RobotModel):
        self._links = np.array(robot.spheres.links)
        self._latest: _Look | None = None
        self._is_first = True
        self._open: dict[tuple[str, int], Contact] = {}
        self._closed: list[Contact] = []

    def add(self, look: _Look) -> None:
        """Adds the next sample, with the robot's motion since the previous one.

        For the first sample, the motion between the first two samples is used.
        """
        before, self._latest = self._latest, look
        if before is None:
            return
        duration = max(look.time - before.time, 1e-12)
        v_WS = (look.p_WS - before.p_WS) / duration
        if self._is_first:
            self._note(before, v_WS)
        self._note(look, v_WS)

    def all(self) -> tuple[Contact, ...]:
        """Returns all contacts, in the order in which they began."""
        if self._is_first and self._latest is not None:
            self._note(self._latest, np.zeros_like(self._latest.p_WS))
        contacts = [*self._closed, *self._open.values()]
        return tuple(sorted(contacts, key=lambda contact: contact.start))

    def _note(self, look: _Look, v_WS: np.ndarray) -> None:
        """Begins, prolongs and ends contacts."""
        self._is_first = False
        seen = {}
        if (look.distance < 0.0).any():
            seen = dict(_touches(look, self._links, v_WS))
        for key in [key for key in self._open if key not in seen]:
            self._closed.append(self._open.pop(key))
        for key, now in seen.items():
            before = self._open.get(key)
            self._open[key] = now if before is None else _merged(before, now)


def _touches(
    look: _Look, links: np.ndarray, v_WS: np.ndarray
) -> Iterator[tuple[tuple[str, int], Contact]]:
    """Yields a sample's contacts, with the link's name and mover's index."""
    mover, sphere = np.nonzero(look.distance < 0.0)
    ahead = np.einsum("ni,ni->n", look.towards_W[mover, sphere], v_WS[sphere])
    speed = np.linalg.norm(v_WS[sphere], axis=1)
    kind = np.where(ahead > LEAST_SPEED, 0, np.where(speed > LEAST_SPEED, 1, 2))
    for j in np.unique(mover):
        for link in np.unique(links[sphere[mover == j]]):
            these = (mover == j) & (links[sphere] == link)
            yield (
                (str(link), int(j)),
                Contact(
                    look.time,
                    look.time,
                    str(link),
                    look.names[j],
                    _MOTIONS[kind[these].min()],
                    float(-look.distance[mover[these], sphere[these]].min()),
                ),
            )


def _merged(before: Contact, now: Contact) -> Contact:
    return dc.replace(
        before,
        end=now.end,
        kind=min(before.kind, now.kind, key=KINDS.index),
        depth=max(before.depth, now.depth),
    )
