"""`Covering`: fits, checks and writes the spheres of a robot's links."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from pathlib import Path

from remosplat_drake.robot.fitting.link_spheres import (
    Bulge,
    LinkSpheres,
    measure_bulge,
)
from remosplat_drake.robot.fitting.model_surfaces import (
    SurfaceOptions,
    model_surfaces,
    surface_points,
)
from remosplat_drake.robot.fitting.sphere_fitting import (
    MOST_SPHERES,
    fit_spheres,
)

_SLIT = 5e-4
"""If the fit left points outside the spheres, spheres are enlarged until these
points are at least this deep inside [m]."""


@dc.dataclass(frozen=True, eq=False)
class Covering:
    """Spheres that enclose the links of a robot.

    Attributes:
        fits: The spheres by link name.
        bulges: Distances by which the spheres protrude from each link, by link
            name.
    """

    fits: dict[str, LinkSpheres]
    bulges: dict[str, Bulge]

    def __len__(self) -> int:
        return sum(len(fit.radius) for fit in self.fits.values())

    def to_yaml(self, comments: Sequence[str]) -> str:
        """Writes the sphere model in tenths of a millimetre, radii rounded up.

        Args:
            comments: Comment lines that state how the model was made.
        """
        lines = [
            *(f"# {line}" for line in comments),
            "# Distances by which they protrude from each link, mean and "
            "largest [mm]:",
            *(
                f"#   {link}: {1e3 * bulge.mean:.1f}, {1e3 * bulge.max:.1f}"
                for link, bulge in self.bulges.items()
            ),
            "# link: [x, y, z, radius] in the link frame [m].",
            "spheres:",
        ]
        for link, fit in self.fits.items():
            lines.append(f"  {link}:")
            for p_LS, radius in zip(fit.p_LS, fit.radius, strict=True):
                # Rounding moves a centre by less than 0.1 mm.
                row = [*p_LS.round(4) + 0.0, round(radius + 1e-4, 4)]
                lines.append(f"  - [{', '.join(f'{x:g}' for x in row)}]")
        return "\n".join(lines) + "\n"


def fit_covering(
    model: Path,
    options: SurfaceOptions,
    *,
    count: int | None = None,
    tolerance: float | None = None,
    most: int = MOST_SPHERES,
    seed: int = 0,
    on_progress: Callable[[str, int, int], None] = lambda what, i, n: None,
) -> Covering:
    """Fits spheres to the links of a model file.

    Args:
        model: URDF, SDF or *.dmd.yaml; link names must be unique in it.
        options: Selection of the surfaces to enclose.
        count: Total number of spheres; None if the tolerance determines this
            number.
        tolerance: Distance by which the spheres may protrude from a link [m].
            Give it only if `count` is None.
        most: With a tolerance: largest number of spheres of a link.
        seed: Seed of all random choices.
        on_progress: Called with the name of the present step, the number of
            finished links, and the number of links.

    Raises:
        RemoSplatError: The model cannot be read, a link is unknown or has no
            geometry, or the spheres are too few.
    """
    on_progress("reading the surfaces", 0, 1)
    surfaces = model_surfaces(model, options, seed)
    on_progress("fitting spheres", 0, len(surfaces))
    done = 0

    def step(link: str, spheres: int) -> None:
        nonlocal done
        done += 1
        on_progress("fitting spheres", done, len(surfaces))

    fits = fit_spheres(
        surfaces,
        count,
        seed,
        on_progress=step,
        tolerance=tolerance,
        most=most,
    )
    # Points that were not used for the fit reveal the slits between spheres.
    on_progress("checking with fresh points", 0, 1)
    fresh = surface_points(model, options, seed + 1)
    fits = {
        link: fit.grown_over(fresh[link], _SLIT) for link, fit in fits.items()
    }
    bulges = {
        link: measure_bulge(fit, surfaces[link].solid)
        for link, fit in fits.items()
    }
    return Covering(fits, bulges)
