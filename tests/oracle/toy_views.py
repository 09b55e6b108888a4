"""Random splats and spheres, and what single precision may answer of them."""

import dataclasses as dc

import numpy as np

from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import N_VIEWS, DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def random_splat(
    rng, n: int, n_scales: int, largest: float = 0.4, uncertain: bool = False
) -> GaussianSplat:
    """Splats of all sizes, in a box of one metre around the origin."""
    return GaussianSplat(
        rng.uniform(-0.5, 0.5, (n, 3)),
        rng.normal(size=(n, 4)),
        np.exp(rng.uniform(np.log(0.005), np.log(largest), (n, n_scales))),
        rng.uniform(0.002, 1.0, n),
        np.zeros((n, 3)),
        uncertainty=rng.uniform(0, 0.03, n) if uncertain else None,
    )


def random_spheres(rng, n: int) -> Spheres:
    """Turned spheres among them, some of which ignore what is low."""
    R_WL = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    R_WL *= np.linalg.det(R_WL)[:, None, None]
    return Spheres(
        rng.uniform(-0.5, 0.5, (n, 3)),
        R_WL,
        rng.uniform(0.02, 0.1, n),
        rng.choice([-np.inf, -0.1], n),
    )


def ranges(
    splat_W: GaussianSplat,
    spheres: Spheres,
    sensor: DepthSensor,
    max_distance: float,
) -> np.ndarray:
    """Ranges of the CPU's nearest pixels, shape (n, 6) [m]; inf for none."""
    field = DepthRasterizationField(splat_W, sensor)
    bound = np.minimum(sensor.far * np.sqrt(3), spheres.radius + max_distance)
    R_WD = np.array(sensor.R_WD(spheres.R_WL), float, order="C")
    return field._nearest_pixels(spheres, R_WD, bound)[0]


def assert_equal_but_for_rounding(
    found: np.ndarray,
    splat_W: GaussianSplat,
    spheres: Spheres,
    sensor: DepthSensor,
    max_distance: float,
) -> None:
    """Compares ranges in single precision with the CPU's.

    Where light just reaches a threshold in double precision, and just misses it
    in single precision, another fragment is the median. So an answer may lie
    between those of sensors with a little different thresholds.

    Args:
        found: Ranges, shape (n, 6) [m].
        splat_W: The scene.
        spheres: Spheres with the sensors.
        sensor: The views.
        max_distance: Up to which distance was asked [m].
    """
    assert found.shape == (len(spheres), N_VIEWS)
    off = 1e-5
    answers = [
        ranges(
            splat_W,
            spheres,
            dc.replace(
                sensor,
                transmittance=sensor.transmittance + off * sign,
                alpha_cutoff=sensor.alpha_cutoff + off * other,
                n_sigma=sensor.n_sigma * (1 + off * third),
            ),
            max_distance,
        )
        for sign, other, third in _SIGNS
    ]
    low, high = np.min(answers, axis=0), np.max(answers, axis=0)
    # A range at the very end of what is asked for may be left out, or not.
    end = np.minimum(sensor.far * np.sqrt(3), spheres.radius + max_distance)
    found = np.where(found > end[:, None] - ROUNDING, np.inf, found)
    high = np.where(high > end[:, None] - ROUNDING, np.inf, high)
    assert (found >= low - ROUNDING).all()
    assert (found <= high + ROUNDING).all()
    seen = np.isfinite(answers[0])
    exactly = np.abs(found[seen] - answers[0][seen]) < 1e-6
    assert exactly.mean() > 0.9 if seen.sum() > 20 else True


ROUNDING = 2e-5
"""What single precision loses, more on rays that graze a disc [m]."""

_SIGNS = (
    (0, 0, 0),
    (1, 1, 0),
    (1, -1, 0),
    (-1, 1, 0),
    (-1, -1, 0),
    (0, 0, 1),
    (0, 0, -1),
)
