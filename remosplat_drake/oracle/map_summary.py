"""`MapSummary`: numbers of splats near the places where a robot works.

An oracle cannot distinguish free space from missing parts of a map. For
example, it reports free space if splats are too faint, cropped away or
misplaced. So the splats of a map are counted before the robot moves.
"""

import dataclasses as dc
from collections.abc import Mapping

import numpy as np

from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    OracleMaker,
    SphereToEllipsoid,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SPLATS, SOLIDS = "splats", "solids"
"""Kinds of maps: a Gaussian splat, or solids of known geometry."""

LAYERS = 10
"""A splat is faint if more than this many splats of its opacity, one behind the
other, are needed to count as a surface in depth views."""

_PARTS = 5
"""The line about a map has at most this many parts about places. If there are
more places, the last part summarises several targets."""


@dc.dataclass(frozen=True)
class Place:
    """A place near which a robot will work.

    Attributes:
        name: Name of the place, for example "the start" or "target 1".
        within_reach: Number of splats or solids that the oracle uses and that
            are within reach of the place.
    """

    name: str
    within_reach: int


@dc.dataclass(frozen=True)
class MapSummary:
    """Numbers of splats or solids in a map and near the robot's places.

    Attributes:
        kind: Either `SPLATS` or `SOLIDS`.
        kept: Number of splats or solids that the oracle uses.
        faint: Number of splats that the oracle ignores because their opacity is
            too low.
        cropped: Number of splats that were cropped away.
        reach: A splat or solid is within reach of a place if it is at most this
            far away [m].
        places: The start and each target, with their numbers.
        ignored: Of all splats within reach of a place, the fraction (0 to 1)
            that the oracle ignores or that were cropped away. Splats of the
            floor do not count, since they are cropped on purpose.
        ignored_opacity: The same fraction, with each splat weighted by its
            opacity.
    """

    kind: str
    kept: int
    faint: int
    cropped: int
    reach: float
    places: tuple[Place, ...]
    ignored: float = 0.0
    ignored_opacity: float = 0.0

    def __str__(self) -> str:
        parts = [f"{self.kept:,} {self.kind}"]
        if self.kind == SPLATS:
            parts.append(f"{self.faint:,} too faint")
            parts.append(f"{self.cropped:,} cropped away")
        few = len(self.places) <= _PARTS
        named = len(self.places) if few else _PARTS - 1
        near = [
            f"of {place.name}: {place.within_reach:,}"
            for place in self.places[:named]
        ]
        others = [place.within_reach for place in self.places[named:]]
        if others:
            near.append(
                f"of each of {len(others):,} other targets: {min(others):,} to"
                f" {max(others):,}"
            )
        return (
            f"{', '.join(parts)}; within {self.reach:.1f} m {', '.join(near)}"
        )


def least_opacity(oracle: OracleMaker) -> float:
    """Returns the opacity below which an oracle ignores a splat.

    Depth views have no such threshold. For them, it is the opacity with which
    `LAYERS` splats, one behind the other, reach `alpha_cutoff`. For the oracles
    of other packages it is unknown, and 0 is returned.
    """
    if isinstance(oracle, SphereToEllipsoid):
        return oracle.min_opacity
    if not isinstance(oracle, DepthRasterization):
        return 0.0
    return 1.0 - (1.0 - oracle.alpha_cutoff) ** (1.0 / LAYERS)


def summarize_solids(
    scene: PrimitiveScene, places: Mapping[str, np.ndarray], reach: float
) -> MapSummary:
    """Counts the solids of a scene with known geometry.

    Args:
        scene: The scene.
        places: Points p_WP near which the robot will work, shape (3,), keyed by
            name [m].
        reach: Solids are within reach of a place if they are at most this far
            away [m].
    """
    field = SignedDistanceField(scene, rows="per_primitive")
    return MapSummary(
        kind=SOLIDS,
        kept=len(scene),
        faint=0,
        cropped=0,
        reach=reach,
        places=tuple(
            Place(name, len(field.clearances(Spheres.at(p_WP), reach)))
            for name, p_WP in places.items()
        ),
    )


def summarize_splat(
    splat_W: GaussianSplat,
    cropped_W: GaussianSplat,
    oracle: OracleMaker,
    places: Mapping[str, np.ndarray],
    *,
    reach: float,
    floor_height: float,
) -> MapSummary:
    """Counts the splats of a map that an oracle uses.

    Args:
        splat_W: The map, after it was cropped.
        cropped_W: The splats that were cropped away.
        oracle: The oracle, which determines the splats that are too faint.
        places: Points p_WP near which the robot will work, shape (3,), keyed by
            name [m].
        reach: Splats are within reach of a place if they are at most this far
            away [m].
        floor_height: Height below which splats belong to the floor [m].
    """
    p_WP = np.array(list(places.values()), np.float32).reshape(-1, 3)
    opaque = splat_W.opacities >= least_opacity(oracle)
    near, known = _within(splat_W.p_GK, p_WP, reach, opaque)
    near = _standing(splat_W, near, floor_height)
    kept = _amount(splat_W, near[opaque[near]])
    ignored = _amount(splat_W, near[~opaque[near]])
    every = np.ones(len(cropped_W), bool)
    near, _ = _within(cropped_W.p_GK, p_WP, reach, every)
    ignored += _amount(cropped_W, _standing(cropped_W, near, floor_height))
    shares = ignored / np.maximum(kept + ignored, 1e-9)
    kept_count = int(np.count_nonzero(opaque))
    return MapSummary(
        kind=SPLATS,
        kept=kept_count,
        faint=len(splat_W) - kept_count,
        cropped=len(cropped_W),
        reach=reach,
        places=tuple(map(Place, places, known)),
        ignored=float(shares[0]),
        ignored_opacity=float(shares[1]),
    )


def _within(
    p_WK: np.ndarray, p_WP: np.ndarray, reach: float, opaque: np.ndarray
) -> tuple[np.ndarray, list[int]]:
    """Finds the points, shape (n, 3), that are within reach of places (k, 3).

    Args:
        p_WK: The points.
        p_WP: The places.
        reach: Largest distance of a point from a place.
        opaque: Which points count, shape (n,).

    Returns:
        The indices (m,) of all points that are within reach of any place, and
        the number of those that count near each place.
    """
    # |K - P|^2 is expanded, with an origin near all places. So a million splats
    # take 20 ms, and rounding errors are far below a millimetre.
    middle = p_WP.mean(axis=0)
    p, c = p_WK - middle, p_WP - middle
    # Points too far away for float32 are not within reach.
    with np.errstate(over="ignore"):
        squared = np.einsum("ij,ij->i", p, p)
    c_squared = np.einsum("ij,ij->i", c, c)
    near = np.flatnonzero(squared <= (reach + np.sqrt(c_squared.max())) ** 2)
    squared, p, opaque = squared[near], p[near], opaque[near]
    any_place, counts = np.zeros(len(near), bool), []
    # One place after the other, since there may be thousands of targets.
    for place, place_squared in zip(c, c_squared, strict=True):
        within = squared - 2.0 * p @ place <= reach**2 - place_squared
        any_place |= within
        counts.append(int(np.count_nonzero(within & opaque)))
    return near[any_place], counts


def _standing(
    splat_W: GaussianSplat, index: np.ndarray, floor_height: float
) -> np.ndarray:
    """Returns the indices of those splats that are above the floor."""
    return index[splat_W.p_GK[index, 2] >= floor_height]


def _amount(splat_W: GaussianSplat, index: np.ndarray) -> np.ndarray:
    """Returns the number and total opacity of splats, shape (2,)."""
    opacity = splat_W.opacities[index].sum(dtype=np.float64)
    return np.array([len(index), opacity])
