"""`find_object_at`: finds an object in a splat, and fits a shape around it."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.fitted_solid import fit_solid
from remosplat_drake.scene.objects.region_growing import find_region
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.shortest_axes import shortest_axes

_FAINTEST = 0.1
"""Gaussians of less opacity belong to no object, as for the oracles."""

_STEP = 0.01
"""Distance of neighbouring points on the tops of known objects [m]."""

_BELOW = 0.001
"""A point is on the top of a known object if the object contains the point this
far below it [m]."""


@dc.dataclass(frozen=True, eq=False)
class FoundObject:
    """An object that was found in a splat.

    Attributes:
        thing: The object. Its shape contains the centres of its Gaussians.
        own: Whether each Gaussian of the splat represents the object, shape
            (N,).
    """

    thing: SceneObject
    own: np.ndarray


def find_object_at(
    splat_W: GaussianSplat,
    near: np.ndarray,
    largest: float,
    name: str,
    mass: float | None = None,
    known: Sequence[SceneObject] = (),
) -> FoundObject:
    """Finds the object that stands around a point, and fits a shape.

    Args:
        splat_W: The splat of the scene, in W.
        near: A point on the object, shape (3,) [m].
        largest: Largest extent of the object along each axis of W [m].
        name: Name of the object.
        mass: Mass of the object [kg]; None if it is unknown.
        known: Known objects that the splat does not contain, on which the
            object may stand.

    Raises:
        RemoSplatError: There is no such object at the point; see
            `find_region` and `fit_solid`.
    """
    rows = np.flatnonzero(splat_W.opacities >= _FAINTEST)
    splat = splat_W.select(rows)
    points = np.asarray(splat.p_GK, float)
    scales = np.zeros((len(splat), 3))
    scales[:, : splat.scales.shape[1]] = splat.scales
    region = find_region(
        points,
        shortest_axes(splat),
        splat.R_GK * scales[:, None, :],
        np.asarray(near, float),
        largest,
        _tops(known, np.asarray(near, float), largest),
    )
    solid = fit_solid(points[region.index], region.bottom, name)
    own = np.zeros(len(splat_W), bool)
    own[rows[region.index]] = True
    return FoundObject(SceneObject(name, solid, mass), own)


def _tops(
    known: Sequence[SceneObject], near: np.ndarray, largest: float
) -> np.ndarray:
    """Samples the highest faces of objects near a point, shape (m, 3) [m]."""
    steps = np.arange(-largest, largest + _STEP, _STEP)
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    tops = [np.zeros((0, 3))]
    for each in known:
        points = np.stack([near[0] + x, near[1] + y, 0.0 * x + each.top], 1)
        below = Spheres.at(points - [0.0, 0.0, _BELOW])
        inside = ObjectField([each]).clearances(below).distance < 0.0
        tops.append(points[inside])
    return np.concatenate(tops)
