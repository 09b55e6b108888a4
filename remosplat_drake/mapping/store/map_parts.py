"""Converts a `SceneMap` to a JSON document and arrays, and back.

The document and arrays contain the map's inputs: the splat, the seen space
around it, and the settings of its fields. They also contain prepared data, such
as hierarchies. These are used only if a seal shows that this program has
written the file. Otherwise they are computed again, because kernels follow the
links of a hierarchy without checks, and the links in an unknown file could be
invalid.
"""

import dataclasses as dc
import math
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.array_file import ArrayFile
from remosplat_drake.base.errors import FileError, RemoSplatError, unknown_name
from remosplat_drake.base.json_fields import JsonFields
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.cuda.depth_rasterization import CudaDepthField
from remosplat_drake.oracle.cuda.sphere_to_ellipsoid import (
    CudaSphereToEllipsoidField,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import (
    UnknownSpaceField,
    unknown_space_field,
)
from remosplat_drake.signals.coverage import SURFACE, UNSEEN, Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import (
    SIDES,
    SurfelTile,
    make_tiles,
    polygon_faces,
)

Arrays = dict[str, np.ndarray]

_SPLAT = tuple(field.name for field in dc.fields(GaussianSplat))
_OPTIONAL = "uncertainty"
_COMPOSITE, _UNKNOWN = "composite", "unknown_space"

_OfSplat = (
    SphereToEllipsoidField
    | DepthRasterizationField
    | CudaSphereToEllipsoidField
    | CudaDepthField
)

_MOST_PARTS = 8
"""A composite field has at most this many parts, and none of them is composite.
"""

_LARGEST = 1e6
"""Numbers in a splat, such as sizes and coordinates in W, have at most this
absolute value [m].
"""


def take_apart(scene_map: SceneMap) -> tuple[dict, Arrays]:
    """Converts a map to a JSON document and named arrays.

    Raises:
        RemoSplatError: The field has a kind that cannot be stored, or belongs
            to another splat.
    """
    arrays: Arrays = {}
    document = {
        "version": scene_map.version,
        "parent": scene_map.parent,
        "frames": scene_map.frames,
        "time": scene_map.time if math.isfinite(scene_map.time) else None,
        "quality": scene_map.quality,
    }
    splat_W, coverage = scene_map.splat_W, scene_map.coverage
    if splat_W is not None:
        document["splat"] = {"content_hash": splat_W.content_hash}
        arrays |= {f"splat.{k}": array for k, array in splat_W.arrays().items()}
    if coverage is not None:
        lower = np.asarray(coverage.lower, float).tolist()
        document["coverage"] = {"lower": lower, "voxel": float(coverage.voxel)}
        arrays["coverage.state"] = coverage.state
    document["field"] = _take_field(scene_map.field, scene_map, "field", arrays)
    tiles = scene_map.tiles
    document["tiles"] = [tile.vertices.shape[1] // SIDES for tile in tiles]
    for name in ("vertices", "colors"):
        columns = [getattr(tile, name).T for tile in tiles]
        arrays[f"tiles.{name}"] = np.concatenate(
            [np.zeros((0, 3), "f4"), *columns]
        )
    return document, arrays


def put_together(file: ArrayFile) -> SceneMap:
    """Makes a map from the document and arrays of a file.

    Raises:
        RemoSplatError: The file is incomplete, or its content is not a map.
    """
    document = file.document
    splat_W = _splat(file) if document.has("splat") else None
    coverage = _coverage(file) if document.has("coverage") else None
    field = document.inner("field")
    return SceneMap(
        version=document.whole("version"),
        parent=document.whole("parent") if document.has("parent") else None,
        frames=document.texts("frames"),
        time=document.number("time") if document.has("time") else -math.inf,
        field=_field(file, field, "field", splat_W, coverage),
        splat_W=splat_W,
        coverage=coverage,
        tiles=_tiles(file, splat_W),
        quality=document.text("quality"),
    )


def _take_field(
    field: DistanceField, scene_map: SceneMap, name: str, arrays: Arrays
) -> dict:
    """Returns the description of a field, and adds its prepared arrays."""
    if isinstance(field, CompositeDistanceField):
        parts = [
            _take_field(part, scene_map, f"{name}.{i}", arrays)
            for i, part in enumerate(field.parts)
        ]
        return {"kind": _COMPOSITE, "rows": field.rows, "parts": parts}
    if isinstance(field, UnknownSpaceField):
        belongs = _is_of_coverage(field, scene_map.coverage)
        description = {"kind": _UNKNOWN}
    elif isinstance(field, _OfSplat):
        belongs = _is_of_splat(field, scene_map.splat_W)
        kind = _KINDS[type(field)]
        description = {"kind": kind, "settings": field.settings}
    else:
        raise RemoSplatError(f"files cannot hold a {type(field).__name__}")
    if not belongs:
        raise RemoSplatError(
            f"its {type(field).__name__} belongs to another splat"
        )
    arrays.update({f"{name}.{k}": v for k, v in field.prepared.items()})
    return description


def _is_of_splat(field: DistanceField, splat_W: GaussianSplat | None) -> bool:
    return splat_W is not None and splat_W.content_hash in field.revision


def _is_of_coverage(
    field: UnknownSpaceField, coverage: Coverage | None
) -> bool:
    if coverage is None:
        return False
    return np.array_equal(field.unseen, coverage.state == UNSEEN)


def _field(
    file: ArrayFile,
    description: JsonFields,
    name: str,
    splat_W: GaussianSplat | None,
    coverage: Coverage | None,
) -> DistanceField:
    """Makes the field that `_take_field` has described."""
    kind = description.text("kind")
    if kind == _COMPOSITE and name == "field":
        parts = description.inners("parts")
        if not 0 < len(parts) <= _MOST_PARTS:
            raise description.error("parts", f"expected 1 to {_MOST_PARTS}")
        return CompositeDistanceField(
            [
                _field(file, part, f"{name}.{i}", splat_W, coverage)
                for i, part in enumerate(parts)
            ],
            description.text("rows"),
        )
    prepared = _prepared(file, f"{name}.")
    if kind == _UNKNOWN and coverage is not None:
        return unknown_space_field(coverage, prepared=prepared)
    if kind in _MAKERS and splat_W is not None:
        settings = description.inner("settings")
        return _MAKERS[kind](settings, splat_W, prepared)
    kinds = [_COMPOSITE, _UNKNOWN, *_MAKERS]
    raise description.error("kind", f"{unknown_name('field', kind, kinds)}")


def _prepared(file: ArrayFile, prefix: str) -> Arrays | None:
    """Returns a field's prepared arrays; None if the file is not sealed."""
    if not file.is_sealed:
        return None
    return {
        name.removeprefix(prefix): file.array(name)
        for name in file.names()
        if name.startswith(prefix)
    }


def _solids(
    settings: JsonFields, splat_W: GaussianSplat, prepared: Arrays | None
) -> DistanceField:
    steps = None
    if settings.has("bisection_steps"):
        steps = settings.whole("bisection_steps", 0, 1000)
    return SphereToEllipsoidField(
        splat_W,
        n_sigma=settings.number("n_sigma", 1e-3, 1e3),
        min_opacity=settings.number("min_opacity", 0, 1),
        bisection_steps=steps,
        num_threads=settings.whole("num_threads", 1, 1024),
        subtract_uncertainty=settings.flag("subtract_uncertainty"),
        prepared=prepared,
    )


def _views(
    settings: JsonFields, splat_W: GaussianSplat, prepared: Arrays | None
) -> DistanceField:
    return DepthRasterizationField(
        splat_W,
        _sensor(settings.inner("sensor")),
        nearest_only=settings.flag("nearest_only"),
        num_threads=settings.whole("num_threads", 1, 1024),
        subtract_uncertainty=settings.flag("subtract_uncertainty"),
        prepared=prepared,
    )


def _solids_on_cuda(
    settings: JsonFields, splat_W: GaussianSplat, prepared: Arrays | None
) -> DistanceField:
    return CudaSphereToEllipsoidField(
        splat_W,
        n_sigma=settings.number("n_sigma", 1e-3, 1e3),
        min_opacity=settings.number("min_opacity", 0, 1),
        subtract_uncertainty=settings.flag("subtract_uncertainty"),
        prepared=prepared,
    )


def _views_on_cuda(
    settings: JsonFields, splat_W: GaussianSplat, prepared: Arrays | None
) -> DistanceField:
    return CudaDepthField(
        splat_W,
        _sensor(settings.inner("sensor")),
        nearest_only=settings.flag("nearest_only"),
        subtract_uncertainty=settings.flag("subtract_uncertainty"),
        prepared=prepared,
    )


def _sensor(sensor: JsonFields) -> DepthSensor:
    return DepthSensor(
        resolution=sensor.whole("resolution", 1, 4096),
        alpha_cutoff=sensor.number("alpha_cutoff"),
        transmittance=sensor.number("transmittance"),
        near=sensor.number("near", 1e-6, _LARGEST),
        far=sensor.number("far", 1e-6, _LARGEST),
        n_sigma=sensor.number("n_sigma", 1e-3, 1e3),
        min_alpha=sensor.number("min_alpha"),
        orientation=sensor.text("orientation"),
        low_pass_filter=sensor.flag("low_pass_filter"),
    )


_MAKERS: dict[
    str, Callable[[JsonFields, GaussianSplat, Arrays | None], DistanceField]
] = {
    "sphere_to_ellipsoid": _solids,
    "depth_rasterization": _views,
    "sphere_to_ellipsoid_cuda": _solids_on_cuda,
    "depth_rasterization_cuda": _views_on_cuda,
}

_KINDS = {
    SphereToEllipsoidField: "sphere_to_ellipsoid",
    DepthRasterizationField: "depth_rasterization",
    CudaSphereToEllipsoidField: "sphere_to_ellipsoid_cuda",
    CudaDepthField: "depth_rasterization_cuda",
}


def _splat(file: ArrayFile) -> GaussianSplat:
    has = set(file.names())
    arrays = {
        name: file.array(f"splat.{name}")
        for name in _SPLAT
        if name != _OPTIONAL or f"splat.{name}" in has
    }
    if file.is_sealed:
        head = file.document.inner("splat")
        return GaussianSplat.restored(arrays, head.text("content_hash"))
    for name, array in arrays.items():
        if array.dtype != np.float32 or not array.ndim:
            raise FileError(
                file.path, f"splat.{name} is not an array of float32"
            )
        if not (np.abs(array) <= _LARGEST).all():
            raise FileError(file.path, f"splat.{name} has numbers above 1e6")
    unit = GaussianSplat(**arrays).quaternions
    if np.abs(unit - arrays["quaternions"]).max(initial=0) > 1e-6:
        raise FileError(file.path, "splat.quaternions are not unit quaternions")
    return GaussianSplat.restored(arrays)


def _coverage(file: ArrayFile) -> Coverage:
    head, state = file.document.inner("coverage"), file.array("coverage.state")
    if state.dtype != np.uint8 or state.ndim != 3 or not state.size:
        raise FileError(file.path, "coverage.state is not a grid of bytes")
    if not file.is_sealed and state.max() > SURFACE:
        raise FileError(file.path, "coverage.state has unknown states")
    lower = np.array(head.numbers("lower", 3))
    if np.abs(lower).max() > _LARGEST:
        raise head.error("lower", f"must lie within {_LARGEST:g} m")
    return Coverage(lower, head.number("voxel", 1e-4, 10.0), state)


def _tiles(
    file: ArrayFile, splat_W: GaussianSplat | None
) -> tuple[SurfelTile, ...]:
    """Returns the tiles; computes them again if the file is not sealed."""
    counts = file.document.wholes("tiles")
    if not file.is_sealed:
        return make_tiles(splat_W) if counts and splat_W is not None else ()
    parts = [file.array(f"tiles.{name}") for name in ("vertices", "colors")]
    ends = SIDES * np.cumsum(counts)
    tiles = []
    for count, end in zip(counts, ends.tolist(), strict=True):
        vertices, colors = (part[end - SIDES * count : end] for part in parts)
        for array in (vertices, colors):
            array.flags.writeable = False
        faces = polygon_faces(count, SIDES)
        tiles.append(SurfelTile(vertices.T, faces.T, colors.T))
    return tuple(tiles)
