"""Finds Gaussians of a splat that are not on surfaces.

Splats from other programs contain floaters, sky and giants, which are splats
that are far too large. These splats are not on surfaces, and make distances too
small. But if a surface is removed by mistake, distances are too large, which is
worse. So splats that touch a large part of the scene are kept, unless they are
nearly transparent or far too large for a surface.

All thresholds of lengths are relative to sizes in the splat, since the unit of
such files is unknown.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.splat.cleaning.groups import (
    Groups,
    Neighbours,
    find_groups,
    find_neighbours,
)
from remosplat_drake.splat.cleaning.views import Views
from remosplat_drake.splat.gaussian_splat import GaussianSplat

KEPT = "kept"
FAINT, GIANT, NEEDLE = "faint", "giant", "needle"
SKY, FLOATER, BEFORE, UNSEEN = "sky", "floater", "before a camera", "unseen"

REASONS = {
    FAINT: "nearly transparent: an opacity below 0.05",
    GIANT: "too large for a surface in this scene, or next to its neighbours",
    NEEDLE: "thin and far longer than its neighbours",
    SKY: "separated from the scene by a gap as wide as the scene",
    FLOATER: "in a small group that touches nothing else",
    BEFORE: "part of a small thing directly in front of a camera",
    UNSEEN: "part of a small thing outside the view of all cameras",
}
"""Reasons for removal, in the order of the tests."""

LEAST_OPACITY = 0.05
"""Opacity below which a splat is faint. It is half the default threshold of the
distance oracle."""

_GIANT = 0.3
"""A splat whose standard deviation exceeds this fraction of a length is not on
a surface. The length is the scene's radius or, if it is larger, the splat's
distance from the middle of the scene."""

_LARGE = 0.1
"""A splat is compared with its neighbours if its standard deviation exceeds
this fraction of a length. The length is that of `_GIANT`."""

_BESIDE = 12.0
"""A splat larger than `_LARGE` is a giant if it is at least this many times as
large as the median of its neighbours."""

_NEEDLE, _LONGER = 15.0, 10.0
"""A needle's length is at least this multiple of its width, and of the median
length of its neighbours."""

_ORDINARY = 20.0
"""The scene's size is computed from splats that are at most this multiple of
the median size."""

_GAP = 2.0
"""A group is outside the scene if all its splats are farther from the middle
than this multiple of the scene's radius."""

FEW = 30
"""A separate group is a part of the scene only if it has at least this many
splats."""

_PART = 0.05
"""A group that contradicts the cameras is removed if it has less than this
fraction of all splats."""


@dc.dataclass(frozen=True, eq=False)
class Junk:
    """The Gaussians to remove from a splat of N Gaussians.

    Attributes:
        reason: Index into `names` for each splat, shape (N,), uint8; 0 is
            `KEPT`.
        middle: Middle of the kept splats, in G, shape (3,).
        radius: Radius around the middle that contains 99 % of the kept splats.
        has_views: Whether the poses of the training cameras were known.
    """

    reason: np.ndarray
    middle: np.ndarray
    radius: float
    has_views: bool

    names = (KEPT, *REASONS)

    @property
    def is_kept(self) -> np.ndarray:
        """Whether each splat is kept, shape (N,), bool."""
        return self.reason == 0

    def counts(self) -> dict[str, int]:
        """Returns the number of splats that are removed for each reason.

        If the cameras are unknown, reasons that need cameras are omitted.
        """
        counts = np.bincount(self.reason, minlength=len(self.names)).tolist()
        asked = dict(zip(REASONS, counts[1:], strict=True))
        if not self.has_views:
            del asked[BEFORE], asked[UNSEEN]
        return asked


def find_junk(
    splat: GaussianSplat,
    views: Views | None = None,
    on_stage: Callable[[str], None] = lambda what: None,
) -> Junk:
    """Finds faint splats, giants, needles, sky and floaters.

    If `views` are given, the function also finds splats directly in front of a
    camera, and splats outside all views, unless these splats belong to a large
    group.

    Args:
        splat: At least one splat in G, in any unit. If fewer than `FEW` splats
            are not faint, all of these are kept.
        views: The training cameras of the splat; None if they are unknown.
        on_stage: Function that is called with the name of each stage when the
            stage begins.
    """
    reason = np.zeros(len(splat), np.uint8)

    def mark(index: np.ndarray, which: np.ndarray, name: str) -> np.ndarray:
        """Marks some of the remaining splats, and returns those not marked."""
        reason[index[which]] = Junk.names.index(name)
        return index[~which]

    left = np.arange(len(splat))
    left = mark(left, splat.opacities < LEAST_OPACITY, FAINT)
    if len(left) >= FEW:
        on_stage("comparing neighbours")
        left = _mark_shapes(splat, left, mark)
    if len(left) >= FEW:
        on_stage("finding what hangs together")
        left = _mark_groups(splat, left, views, mark)
    p_GK = splat.p_GK[left if len(left) else slice(None)].astype(float)
    middle = np.median(p_GK, axis=0)
    distance = np.linalg.norm(p_GK - middle, axis=1)
    radius = float(np.quantile(distance, 0.99))
    return Junk(reason, middle, radius, views is not None)


def _mark_shapes(splat: GaussianSplat, left: np.ndarray, mark) -> np.ndarray:
    """Marks giants and needles, and returns the splats that are not marked."""
    part = splat.select(left)
    size = part.scales.max(axis=1)
    middle, reach = _extent(part, size)
    neighbours = find_neighbours(part.p_GK)
    beside = _beside(size, neighbours)
    distance = np.linalg.norm(part.p_GK - middle, axis=1)
    least = np.maximum(reach, distance)
    # A giant is among smaller neighbours. A large splat without near neighbours
    # is not one: it may represent a whole wall.
    is_amid = neighbours.distance[:, -1] <= size
    is_huge = size > _GIANT * least
    is_thin = size > _NEEDLE * np.sort(part.scales, axis=1)[:, -2]
    is_needle = ~is_huge & is_thin & is_amid & (size > _LONGER * beside)
    is_giant = (size > _LARGE * least) & (size > _BESIDE * beside) & is_amid
    is_giant = is_huge | (is_giant & ~is_needle)
    rest = mark(left, is_giant, GIANT)
    return mark(rest, is_needle[~is_giant], NEEDLE)


def _extent(part: GaussianSplat, size: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns middle and radius of the scene, from splats of ordinary size."""
    ordinary = part.select(size <= _ORDINARY * np.median(size))
    groups = find_groups(ordinary)
    p_GK = ordinary.p_GK.astype(float)
    middle, distance = _from_middle(p_GK, groups)
    _, reach = _scene(groups, distance)
    return middle, reach


def _beside(size: np.ndarray, neighbours: Neighbours) -> np.ndarray:
    """Returns the median size of each splat's neighbours, shape (n,)."""
    known = np.append(size, np.nan)
    sizes = known[neighbours.index]
    return np.nanmedian(sizes, axis=1)


def _mark_groups(
    splat: GaussianSplat, left: np.ndarray, views: Views | None, mark
) -> np.ndarray:
    """Marks sky, floaters, and groups that contradict the cameras."""
    part = splat.select(left)
    groups = find_groups(part)
    p_GK = part.p_GK.astype(float)
    _, distance = _from_middle(p_GK, groups)
    is_scene, _ = _scene(groups, distance)
    is_sky = ~is_scene[groups.label]
    is_few = (groups.size < FEW) & (groups.size < groups.size.max())
    is_floater = ~is_sky & is_few[groups.label]
    before = unseen = np.zeros(len(left), bool)
    if views is not None:
        is_part = groups.size < _PART * len(left)
        asked = np.flatnonzero(is_part[groups.label] & ~is_sky & ~is_floater)
        before, unseen = _contradicted(p_GK, groups, asked, views)
    for name, which in (
        (SKY, is_sky),
        (FLOATER, is_floater),
        (BEFORE, before),
        (UNSEEN, unseen),
    ):
        mark(left, which, name)
    return left[~(is_sky | is_floater | before | unseen)]


def _from_middle(
    p_GK: np.ndarray, groups: Groups
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the middle of the largest group, and all distances from it."""
    middle = np.median(p_GK[groups.label == groups.largest], axis=0)
    return middle, np.linalg.norm(p_GK - middle, axis=1)


def _scene(groups: Groups, distance: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns whether each group belongs to the scene, and the scene's radius.

    Groups are processed in the order of their distance from the middle of the
    largest group. A group belongs to the scene if it starts within `_GAP` times
    the radius of the groups before it. Small groups do not increase the radius;
    otherwise a few stray splats would connect the scene to the sky.
    """
    nearest, farthest = groups.least(distance), groups.greatest(distance)
    is_large = groups.size >= FEW
    is_large[groups.largest] = True
    reach = farthest[groups.largest]
    for group in np.flatnonzero(is_large)[np.argsort(nearest[is_large])]:
        if nearest[group] > _GAP * reach:
            break
        reach = max(reach, farthest[group])
    return nearest <= _GAP * reach, float(reach)


def _contradicted(
    p_GK: np.ndarray, groups: Groups, asked: np.ndarray, views: Views
) -> tuple[np.ndarray, np.ndarray]:
    """Masks the splats of groups in front of a camera, and of unseen groups."""
    n, label = len(p_GK), groups.label[asked]
    scene_G = p_GK[groups.label == groups.largest]
    is_seen, is_before = views.look(p_GK[asked], scene_G)
    seen = np.bincount(label, is_seen, len(groups.size))
    before = np.bincount(label, is_before, len(groups.size))
    in_before, in_unseen = np.zeros(n, bool), np.zeros(n, bool)
    in_before[asked] = (before > 0.5 * groups.size)[label]
    in_unseen[asked] = (seen == 0)[label]
    return in_before, in_unseen & ~in_before
