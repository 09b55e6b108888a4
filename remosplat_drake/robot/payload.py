"""`Payload`: a rigid object that a link of a robot carries."""

import dataclasses as dc
import hashlib
from functools import cached_property

import numpy as np

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres


@dc.dataclass(frozen=True, eq=False)
class Payload:
    """An object as a further link of a robot, welded to the link L.

    Payloads of equal content compare equal, also in different processes.

    Attributes:
        name: Name of the object, and of the link that represents it.
        link: Name of the link L that carries it.
        X_LO: Pose of the object's frame O in L, shape (4, 4).
        spheres: Spheres in O that enclose the object.
        pieces: Vertices of convex pieces in O whose union encloses it, shape
            (v, 3) each [m].
        mass: Mass of the object [kg]; 0 if it is unknown.
        p_OOcm: Centre of mass of the object in O, shape (3,) [m].
        I_OOcm: Rotational inertia of the object about the centre of mass, in O,
            shape (3, 3) [kg m^2].
        holders: Names of the links that hold the object and may touch it.
    """

    name: str
    link: str
    X_LO: np.ndarray
    spheres: LinkSpheres
    pieces: tuple[np.ndarray, ...]
    mass: float = 0.0
    p_OOcm: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    I_OOcm: np.ndarray = dc.field(default_factory=lambda: np.zeros((3, 3)))
    holders: frozenset[str] = frozenset()

    def __deepcopy__(self, memo) -> "Payload":
        return self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Payload) and self.revision == other.revision

    def __hash__(self) -> int:
        return hash(self.revision)

    @cached_property
    def revision(self) -> str:
        """A digest of its content."""
        digest = hashlib.sha256()
        names = self.name, self.link, *sorted(self.holders)
        digest.update("\n".join(names).encode())
        arrays = self.X_LO, self.spheres.p_LS, self.spheres.radius
        inertia = np.array(self.mass), self.p_OOcm, self.I_OOcm
        for array in (*arrays, *self.pieces, *inertia):
            digest.update(np.ascontiguousarray(array, float).tobytes())
        return digest.hexdigest()[:16]
