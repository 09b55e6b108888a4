"""`SphereModel`: the robot's collision geometry as spheres on links."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import yaml

from remosplat_drake.errors import FieldError, FileError
from remosplat_drake.robot.link_spheres import LinkSpheres


@dc.dataclass(frozen=True, eq=False)
class SphereModel:
    """n spheres S, each fixed to a link L (paper section III-B).

    Whether they enclose the robot, and what that means, is said and proved
    in `remosplat_drake.robot.enclosure`.

    Attributes:
        name: What the set is called, for tables and logs.
        links: Name of each sphere's link, length n.
        p_LS: Centre of each sphere in its link frame, shape (n, 3) [m].
        radius: Shape (n,) [m].
    """

    name: str
    links: tuple[str, ...]
    p_LS: np.ndarray
    radius: np.ndarray

    def __len__(self) -> int:
        return len(self.links)

    def __deepcopy__(self, memo) -> "SphereModel":
        return self

    def on_links(self, links: set[str]) -> np.ndarray:
        """Boolean mask of the spheres that are fixed to one of `links`."""
        return np.array([link in links for link in self.links], bool)

    def on_link(self, link: str) -> LinkSpheres:
        """The spheres of one link in its frame; there may be none."""
        mask = self.on_links({link})
        return LinkSpheres(self.p_LS[mask], self.radius[mask])


@dc.dataclass(frozen=True, eq=False)
class Spheres:
    """n robot spheres placed in the world: what a distance field is asked.

    Attributes:
        p_WS: Centres, shape (n, 3) [m].
        R_WL: Orientations of the spheres' links, shape (n, 3, 3).
        radius: Shape (n,) [m].
        ignore_below: Sphere i does not see scene points that lie below this
            height z in W, shape (n,) [m]; -inf sees everything. It keeps the
            floor from blinding a mobile base (which always touches it).
    """

    p_WS: np.ndarray
    R_WL: np.ndarray
    radius: np.ndarray
    ignore_below: np.ndarray

    def __len__(self) -> int:
        return len(self.radius)

    def select(self, index: np.ndarray) -> "Spheres":
        """The spheres that a boolean mask or index array names."""
        return Spheres(
            self.p_WS[index],
            self.R_WL[index],
            self.radius[index],
            self.ignore_below[index],
        )

    @staticmethod
    def at(
        p_WS: np.ndarray,
        radius: np.ndarray | float = 0.0,
        ignore_below: float = -np.inf,
    ) -> "Spheres":
        """Spheres at points, with links aligned to W."""
        p_WS = np.atleast_2d(np.asarray(p_WS, float))
        n = len(p_WS)
        return Spheres(
            p_WS,
            np.broadcast_to(np.eye(3), (n, 3, 3)).copy(),
            np.broadcast_to(np.asarray(radius, float), (n,)).copy(),
            np.full(n, ignore_below),
        )


def load_sphere_model(path: Path) -> SphereModel:
    """Reads a sphere model from YAML.

    The file is a mapping with the key `spheres`: link name to a list of
    `[x, y, z, radius]` in the link frame [m].

    Raises:
        FileError: The file cannot be read or is not such a mapping.
        FieldError: A sphere is not four finite numbers with radius > 0.
    """
    try:
        document = yaml.safe_load(path.read_text())
    except (OSError, yaml.YAMLError, UnicodeDecodeError) as error:
        raise FileError(path, " ".join(str(error).split())) from error
    if not isinstance(document, dict) or not isinstance(
        document.get("spheres"), dict
    ):
        raise FileError(path, "expected a mapping `spheres: {link: [...]}`")
    links: list[str] = []
    rows: list[list[float]] = []
    for link, entries in document["spheres"].items():
        for i, entry in enumerate(entries or []):
            row = _checked_row(entry, f"spheres.{link}[{i}]", path)
            links.append(str(link))
            rows.append(row)
    if not rows:
        raise FileError(path, "holds no spheres")
    table = np.array(rows, float)
    return SphereModel(path.stem, tuple(links), table[:, :3], table[:, 3])


def _checked_row(entry: object, field: str, path: Path) -> list[float]:
    numbers = isinstance(entry, list) and all(
        isinstance(x, (int, float)) and not isinstance(x, bool) for x in entry
    )
    if not (numbers and len(entry) == 4 and np.isfinite(entry).all()):  # pyright: ignore
        raise FieldError(
            str(path), field, f"expected [x, y, z, radius], got {entry!r}"
        )
    if entry[3] <= 0:  # pyright: ignore
        raise FieldError(str(path), field, "the radius must be positive")
    return [float(x) for x in entry]  # pyright: ignore
