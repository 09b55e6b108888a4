"""Floaters: splats that hang in space through which cameras have looked."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True, eq=False)
class Floaters:
    """n floaters, the worst first.

    Attributes:
        index: In the splat, shape (n,).
        p_WK: Centres, shape (n, 3) [m].
        height: From the centre to the nearest real surface: by so much a
            robot there is told to be too near, shape (n,) [m].
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
    """The splats that some views contradict.

    Args:
        splat_W: The splat.
        capture: Posed RGB-D images of the same scene.
        truth: Distances to the real surfaces.
        lower: Lower corner of a box in W; floaters outside are left out,
            shape (3,) [m].
        upper: Upper corner, shape (3,) [m].
        min_opacity: More transparent splats disturb no oracle.
        min_views: So many views must have looked through the centre.
        margin: See `times_looked_through`; surfaces nearer to a floater than
            this show in the distance errors instead [m].
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
