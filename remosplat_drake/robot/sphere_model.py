"""`SphereModel`: the robot's collision geometry as spheres on links."""

import dataclasses as dc
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Len

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.ranges import Coordinate
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.link_table import LinkTable, load_link_table


@dc.dataclass(frozen=True, eq=False)
class SphereModel:
    """n spheres S, each fixed to a link L (paper section IV-B).

    `remosplat_drake.robot.fitting.enclosure` defines when spheres enclose the
    robot, and proves it.

    Attributes:
        name: Name of the sphere set, for tables and logs.
        links: Name of each sphere's link, length n.
        p_LS: Centre of each sphere in its link frame, shape (n, 3) [m].
        radius: Radii, shape (n,) [m].
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
        """Returns a mask of the spheres that are fixed to `links`, (n,)."""
        return np.array([link in links for link in self.links], bool)

    def with_link(self, link: str, spheres: LinkSpheres) -> "SphereModel":
        """Returns the model, with the spheres of a further link at the end.

        Args:
            link: Name of the link.
            spheres: Spheres of the link, in the link's frame.
        """
        return SphereModel(
            self.name,
            (*self.links, *[link] * len(spheres.radius)),
            np.concatenate([self.p_LS, spheres.p_LS]),
            np.concatenate([self.radius, spheres.radius]),
        )

    def on_link(self, link: str) -> LinkSpheres:
        """Returns the spheres of one link in its frame; there may be none."""
        mask = self.on_links({link})
        return LinkSpheres(self.p_LS[mask], self.radius[mask])


@dc.dataclass(frozen=True, eq=False)
class Spheres:
    """n robot spheres placed in the world: the argument of distance queries.

    Attributes:
        p_WS: Centres in W, shape (n, 3) [m].
        R_WL: Orientations of the spheres' links in W, shape (n, 3, 3).
        radius: Radii, shape (n,) [m].
        ignore_below: Height z in W below which each sphere ignores the scene,
            shape (n,) [m]; -inf for none. Without such a height, a mobile base,
            which always touches the floor, could not move.
        index: Index of each sphere among the robot's spheres, shape (n,); -1
            for a sphere that does not belong to the robot. The default is -1
            for all.
    """

    p_WS: np.ndarray
    R_WL: np.ndarray
    radius: np.ndarray
    ignore_below: np.ndarray
    index: np.ndarray = dc.field(default=None)  # pyright: ignore

    def __post_init__(self):
        if self.index is None:
            object.__setattr__(self, "index", np.full(len(self.radius), -1))

    def __len__(self) -> int:
        return len(self.radius)

    def select(self, index: np.ndarray) -> "Spheres":
        """Returns the spheres that a boolean mask or index array selects."""
        return Spheres(
            self.p_WS[index],
            self.R_WL[index],
            self.radius[index],
            self.ignore_below[index],
            self.index[index],
        )

    @staticmethod
    def at(
        p_WS: np.ndarray,
        radius: np.ndarray | float = 0.0,
        ignore_below: float = -np.inf,
    ) -> "Spheres":
        """Places spheres at points, with links aligned to W.

        Args:
            p_WS: Centres, shape (n, 3) [m].
            radius: One radius for all, or shape (n,) [m].
            ignore_below: Height below which the scene is ignored [m].
        """
        p_WS = np.atleast_2d(np.asarray(p_WS, float))
        n = len(p_WS)
        return Spheres(
            p_WS,
            np.broadcast_to(np.eye(3), (n, 3, 3)).copy(),
            np.broadcast_to(np.asarray(radius, float), (n,)).copy(),
            np.full(n, ignore_below),
        )


SphereRow = Annotated[list[Coordinate], Len(4, 4)]
"""Centre x, y, z and radius of a sphere in its link's frame [m]."""

LARGEST = 10.0
"""The radius of a sphere may not exceed this [m]."""


@dc.dataclass
class SphereFile(LinkTable):
    """The content of a YAML file with the spheres of every link of a robot."""

    # Rows [x, y, z, radius] by link name [m]; a link may have none.
    spheres: dict[str, list[SphereRow] | None] = dc.field(default_factory=dict)

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that radii are positive and at most `LARGEST`."""
        for link, rows in self.spheres.items():
            for i, (*_, radius) in enumerate(rows or []):
                if not 0 < radius <= LARGEST:
                    yield (
                        f"spheres.{link}[{i}]",
                        "the radius must be positive and at most"
                        f" {LARGEST:g}, got {radius}",
                    )


def load_sphere_model(path: Path) -> SphereModel:
    """Reads the spheres of a robot from a YAML file, a `SphereFile`.

    Raises:
        FileError: The file cannot be read, or contains no spheres.
        FieldError: A sphere is not four finite numbers with radius > 0, or
            `include` names a file that is missing or invalid.
    """
    spheres = load_link_table(SphereFile, path, "spheres")
    links = [link for link, rows in spheres.items() for _ in rows or []]
    if not links:
        raise FileError(path, "holds no spheres")
    table = np.array([row for rows in spheres.values() for row in rows or []])
    return SphereModel(path.stem, tuple(links), table[:, :3], table[:, 3])
