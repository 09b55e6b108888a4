"""Floaters: splats in space that cameras have seen as free."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True, eq=False)
class Floaters:
    """n floaters of a splat, the worst first.

    Attributes:
        index: Indices in the splat, shape (n,).
        p_WK: Centres, shape (n, 3) [m].
        height: Distance from the centre to the nearest real surface, shape (n,)
            [m]. A distance to the floater is too small by this length.
    """

    index: np.ndarray
    p_WK: np.ndarray
    height: np.ndarray

    def __len__(self) -> int:
        return len(self.index)


def find_floaters(
    splat_W: GaussianSplat,
    capture: Capture,
    truth: DistanceField,
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    min_opacity: float = 0.1,
    min_views: int = 2,
    margin: float = 0.03,
) -> Floaters:
    """Finds splats in space that some views have seen as free.

    Args:
        splat_W: The splat in W.
        capture: Posed RGB-D images of the same scene.
        truth: Distance field of the real surfaces.
        lower: Lower corner of a box in W, shape (3,) [m]; floaters outside are
            left out.
        upper: Upper corner of the box, shape (3,) [m].
        min_opacity: Least opacity of a floater; oracles ignore less opaque
            splats.
        min_views: Least number of views that have measured a surface behind the
            centre.
        margin: Margin of `times_looked_through` [m]. Splats that are nearer to
            a surface are not floaters: the distance errors contain their
            effect.
    """
    inside = ((splat_W.p_GK >= lower) & (splat_W.p_GK <= upper)).all(axis=1)
    candidate = np.flatnonzero(inside & (splat_W.opacities >= min_opacity))
    p_WK = splat_W.p_GK[candidate].astype(float)
    through = times_looked_through(capture, p_WK, margin) >= min_views
    candidate, p_WK = candidate[through], p_WK[through]
    near = truth.clearances(Spheres.at(p_WK.reshape(-1, 3)))
    height = near.per_sphere(len(p_WK))
    real = np.flatnonzero((height > margin) & np.isfinite(height))
    worst = real[np.argsort(-height[real], kind="stable")]
    return Floaters(candidate[worst], p_WK[worst], height[worst])
