"""Splats with junk planted in them, of which it is known what is what."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.splat.cleaning.junk import (
    FAINT,
    FLOATER,
    GIANT,
    KEPT,
    NEEDLE,
    SKY,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

PLANTED = {FAINT: 100, GIANT: 10, NEEDLE: 30, SKY: 1500, FLOATER: 160}
"""How many splats are planted of each kind."""


def splats_at(
    p_GK, scales, rng: np.random.Generator, opacity: float = 0.8
) -> GaussianSplat:
    """Splats of one size and opacity, turned at random."""
    n = len(p_GK)
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=rng.normal(size=(n, 4)),
        scales=np.broadcast_to(scales, (n, np.shape(scales)[-1])),
        opacities=np.full(n, opacity),
        colors=np.full((n, 3), 0.5),
    )


def with_junk(
    splat: GaussianSplat, seed: int = 0
) -> tuple[GaussianSplat, np.ndarray]:
    """Plants junk in a clean splat of some metres.

    Returns:
        The splat with the junk at its end, and what each splat is, (n,).
    """
    rng = np.random.default_rng(seed)
    lower, upper = splat.p_GK.min(axis=0), splat.p_GK.max(axis=0)
    middle, R = 0.5 * (lower + upper), 0.5 * np.linalg.norm(upper - lower)
    free = rng.uniform(lower, upper, (20_000, 3))
    free = free[KDTree(splat.p_GK).query(free)[0] > 0.12 * R]
    out = rng.normal(size=(PLANTED[SKY], 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    pairs = free[60:110, None] + 0.01 * R * rng.normal(size=(50, 2, 3))
    singles = splats_at(free[:60], [0.01 * R] * 3, rng)
    needle = [0.15 * R, 5e-4 * R, 5e-4 * R]
    on_surfaces = splat.p_GK[rng.integers(0, len(splat), PLANTED[NEEDLE])]
    planted = {
        FAINT: splats_at(free[200:300], [0.02 * R] * 3, rng, 0.02),
        GIANT: splats_at(free[300:310], [0.6 * R] * 3, rng),
        NEEDLE: splats_at(on_surfaces, needle, rng),
        SKY: splats_at(middle + 12 * R * out, [0.5 * R] * 3, rng),
        FLOATER: singles.joined_with(
            splats_at(pairs.reshape(-1, 3), [0.008 * R] * 3, rng)
        ),
    }
    n_axes = splat.scales.shape[1]
    whole = splat.without_harmonics().with_uncertainty(None)
    kinds = [np.full(len(splat), KEPT, object)]
    for kind, junk in planted.items():
        arrays = junk.arrays() | {"scales": junk.scales[:, :n_axes]}
        whole = whole.joined_with(GaussianSplat(**arrays))
        kinds.append(np.full(len(junk), kind, object))
    return whole, np.concatenate(kinds)
