"""Fits a few spheres around the links of a robot.

For a sphere with centre c inside a body and radius r, the *bulge* r - depth(c)
is the distance by which it protrudes where the surface is nearest. A greedy set
cover over many interior centres finds the number of spheres that a link needs
for a given bulge. Bisection on the bulge, scaled by each link's thickness,
distributes a total number of spheres evenly. Then the centres move until the
bulge cannot shrink further. Every surface point ends up inside a sphere.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy import ndimage

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.kernels.sphere_cover import (
    close_covered,
    count_covered,
    enclosing_radii,
    move_centers,
    needed_bulges,
)
from remosplat_drake.robot.fitting.link_spheres import (
    LinkSpheres,
    measure_bulge,
)
from remosplat_drake.robot.fitting.solid_grid import SolidGrid, make_solid_grid

_MAX_CANDIDATES = 3000
_MAX_POINTS = 4000
_CELLS, _FEWEST, _MOST_CELLS = 80, 20, 160
_FINEST, _COARSEST = 0.001, 0.005
_ROUNDS = 30

POINTS_PER_VOXEL = 2.5
"""Number of surface points along a voxel's edge. With this density, the points
lie in all of the surface's voxels."""

MOST_SPHERES = 16
"""If a tolerance is given, a link gets at most this many spheres by default."""


@dc.dataclass(frozen=True, eq=False)
class LinkSurface:
    """The surface of one link that spheres have to cover.

    Attributes:
        points: Points on the surface in the link frame, shape (n, 3) [m].
        solid: The body that the points enclose, joined with the parts of
            neighbours inside it.
        thickness: Largest depth of the body alone [m].
        weight: Weight of the link. With a larger weight, the link's spheres
            protrude less.
        floor: Whether the link stands on the plane z = 0; then no centre goes
            below it.
    """

    points: np.ndarray
    solid: SolidGrid
    thickness: float
    weight: float = 1.0
    floor: bool = False


def voxel_pitch(extent: np.ndarray) -> float:
    """Returns the voxel edge for a link [m].

    A larger link has more voxels, within limits. Voxels below a millimetre are
    used only for links shorter than 20 mm. Hands with many small finger links
    do not need finer spheres than other robots.

    Args:
        extent: Edges of the link's bounding box, shape (3,) [m].
    """
    longest = float(np.max(extent))
    pitch = min(longest / _CELLS, _COARSEST)
    return max(pitch, longest / _MOST_CELLS, min(_FINEST, longest / _FEWEST))


def make_link_surface(
    points: np.ndarray, weight: float = 1.0, floor: bool = False
) -> LinkSurface:
    """Prepares the surface of a link for the fit.

    Args:
        points: Points on the surface, `POINTS_PER_VOXEL` along a voxel's edge,
            shape (n, 3) [m].
        weight: Weight of the link. With a larger weight, the link's spheres
            protrude less.
        floor: Whether the link stands on the plane z = 0, see
            `make_solid_grid`.

    Raises:
        RemoSplatError: There are no points.
    """
    if len(points) == 0:
        raise RemoSplatError("a link has no geometry to fit spheres to")
    pitch = voxel_pitch(np.ptp(points, axis=0))
    solid = make_solid_grid(points, pitch, floor)
    thickness = max(float(solid.depth.max()), pitch)
    return LinkSurface(points, solid, thickness, weight, floor)


def fit_spheres(
    surfaces: dict[str, LinkSurface],
    count: int | None = None,
    seed: int = 0,
    margin: float = 0.3,
    restarts: int = 6,
    on_progress: Callable[[str, int], None] = lambda link, spheres: None,
    tolerance: float | None = None,
    most: int = MOST_SPHERES,
) -> dict[str, LinkSpheres]:
    """Fits spheres to all links, given their total number or a tolerance.

    Args:
        surfaces: The surfaces by link name.
        count: Largest total number of spheres, at least one for each link; None
            for as many as the tolerance needs.
        seed: Seed of all random choices.
        margin: Least depth of the points inside the spheres, in voxel edges of
            their link.
        restarts: Number of additional initial covers that are refined for each
            link; the best result is kept.
        on_progress: Called after each finished link with its name and its
            number of spheres.
        tolerance: If `count` is None: largest bulge of a link of weight 1 [m].
            The bulge of another link is divided by the link's weight.
        most: With a tolerance: largest number of spheres of a link. If these do
            not suffice, the bulge exceeds the tolerance.

    Raises:
        RemoSplatError: There are fewer spheres than links need.
    """
    if count is not None and count < len(surfaces):
        raise RemoSplatError(
            f"{count} spheres are too few for {len(surfaces)} links; each link"
            " needs at least one"
        )

    def problem(link: str) -> _CoverProblem:
        rng = np.random.default_rng(seed)
        return _CoverProblem(surfaces[link], margin, rng)

    result = {}
    if count is not None:
        problems = {link: problem(link) for link in surfaces}
        for link, start in _share(problems, count).items():
            result[link] = problems[link].solve(start, restarts)
            on_progress(link, len(result[link].radius))
        return result
    assert tolerance is not None
    # A problem takes much memory, so only one exists at a time.
    for link, surface in surfaces.items():
        cover = problem(link)
        start = cover.within(tolerance / surface.weight, most)
        result[link] = cover.solve(start, restarts)
        on_progress(link, len(result[link].radius))
    return result


class _CoverProblem:
    """The set cover of one link: points to cover, and candidate centres."""

    def __init__(
        self, surface: LinkSurface, margin: float, rng: np.random.Generator
    ):
        self._all_points = surface.points
        self._margin = margin * surface.solid.pitch
        self._rng = rng
        self._lowest = 0.0 if surface.floor else -np.inf
        self._solid = surface.solid
        self._thickness = surface.thickness
        # The spheres of a link that is four times as thick may bulge twice as
        # much.
        self.scale = np.sqrt(self._thickness) / surface.weight
        self._points = _thin(surface.points, _MAX_POINTS, rng)
        centres = _candidates(self._solid, rng)
        self._centres = centres[centres[:, 2] >= self._lowest]
        depth = self._solid.depth_at(self._centres)
        self._need = needed_bulges(self._points, self._centres, depth)

    def greedy(
        self, bulge: float, limit: int, randomness: float = 0.0
    ) -> list[int] | None:
        """Returns centres that cover all points; None if more than `limit`."""
        enough = np.float32(bulge - self._margin)
        is_open = np.ones(len(self._points), bool)
        gain = count_covered(self._need, enough)
        chosen: list[int] = []
        while is_open.any():
            if gain.max() == 0 or len(chosen) == limit:
                return None
            luck = 1 - randomness * self._rng.random(len(gain))
            chosen.append(int((gain * luck).argmax()))
            close_covered(self._need, enough, chosen[-1], is_open, gain)
        return chosen

    def within(self, bulge: float, limit: int) -> list[int]:
        """Returns centres that cover all points, with more bulge if needed."""
        while (chosen := self.greedy(bulge, limit)) is None:
            bulge *= 1.1
        return chosen

    def solve(self, chosen: list[int], restarts: int) -> LinkSpheres:
        """Returns the best of several refinements from different covers."""
        starts = [chosen]
        count = len(chosen)
        # Random covers with a slightly larger bulge need no more spheres.
        bulge = self._need[:, chosen].min(axis=1).max() + self._margin
        for slack in np.linspace(1.0, 1.3, restarts):
            start = self.greedy(slack * bulge, count, 0.3)
            if start is not None:
                starts.append(self._fill_up(start, count))
        results = [self._refine(self._centres[start]) for start in starts]
        return min(results, key=self._cost)

    def _fill_up(self, chosen: list[int], count: int) -> list[int]:
        """Adds centres where the bulge is largest."""
        chosen = list(chosen)
        while len(chosen) < count:
            neediest = self._need[:, chosen].min(axis=1).argmax()
            chosen.append(int(self._need[neediest].argmin()))
        return chosen

    def _cost(self, spheres: LinkSpheres) -> float:
        bulge = measure_bulge(spheres, self._solid, 200)
        return bulge.max + bulge.mean

    def _refine(self, p_LS: np.ndarray) -> LinkSpheres:
        """Moves centres until their bulges stop shrinking.

        It alternates two steps, neither of which can increase the largest
        bulge: each point is assigned to the sphere that covers it with the
        least bulge, and each centre moves to the place at which its points need
        the least bulge.
        """
        p_LS = p_LS.copy()
        solid = self._solid
        step = 0.5 * self._thickness
        for _ in range(_ROUNDS):
            move_centers(
                self._points,
                p_LS,
                self._lowest,
                step,
                solid.depth,
                solid.origin,
                solid.pitch,
            )
            step = max(0.82 * step, 0.05 * solid.pitch)
        return self._enclose(p_LS)

    def _enclose(self, p_LS: np.ndarray) -> LinkSpheres:
        """Returns the smallest radii that enclose all surface points."""
        depth = self._solid.depth_at(p_LS)
        radius = enclosing_radii(self._all_points, p_LS, depth)
        used = radius > 0
        return LinkSpheres(p_LS[used], radius[used] + self._margin)


def _share(
    problems: dict[str, _CoverProblem], count: int
) -> dict[str, list[int]]:
    """Distributes the spheres so that links bulge equally for their size."""

    def cover(scale: float) -> dict[str, list[int]] | None:
        covers, left = {}, count
        for link, problem in problems.items():
            cover = problem.greedy(scale * problem.scale, left)
            if cover is None:
                return None
            covers[link] = cover
            left -= len(cover)
        return covers

    low, high = 0.0, 0.01
    best = cover(high)
    while best is None:
        low, high = high, 2.0 * high
        if high > 1e6:
            raise RemoSplatError(
                f"{count} spheres cannot cover the links; allow more"
            )
        best = cover(high)
    while high - low > 0.01 * high:
        middle = 0.5 * (low + high)
        found = cover(middle)
        if found is None:
            low = middle
        else:
            best, high = found, middle
    return best


def _candidates(solid: SolidGrid, rng: np.random.Generator) -> np.ndarray:
    """Draws interior centres: on the medial ridge, and further shallow ones.

    Edges and corners need small spheres near them. Uniformly drawn voxels of a
    thick body contain few such centres.
    """
    depth = solid.depth
    # A sheet without a core has a ridge, too.
    ridge = (depth >= 0) & (depth >= ndimage.maximum_filter(depth, 3))
    rest = np.argwhere((depth > 0) & ~ridge)
    p_ridge = solid.origin + solid.pitch * np.argwhere(ridge)
    p_ridge = _thin(p_ridge, _MAX_CANDIDATES // 2, rng)
    count = min(_MAX_CANDIDATES - len(p_ridge), len(rest))
    chance = 1 / (depth[tuple(rest.T)] + solid.pitch)
    # The smallest of independent exponential variables are a weighted draw
    # without replacement.
    drawn = np.argsort(rng.exponential(size=len(rest)) / chance)[:count]
    return np.vstack([p_ridge, solid.origin + solid.pitch * rest[drawn]])


def _thin(
    points: np.ndarray, most: int, rng: np.random.Generator
) -> np.ndarray:
    if len(points) <= most:
        return points
    return points[np.sort(rng.choice(len(points), most, replace=False))]
