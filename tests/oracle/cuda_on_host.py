"""Runs the CUDA kernels on the CPU, by one thread: what they compute, not how.

The sources are compiled by g++ behind `host_device.hpp`.
"""

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.oracle.cuda import depth_rasterization as views
from remosplat_drake.oracle.cuda import sphere_to_ellipsoid as solids
from remosplat_drake.oracle.cuda.clusters import Clusters, ClustersArgument
from remosplat_drake.oracle.cuda.device import sphere_rows
from remosplat_drake.oracle.cuda.program import SOURCES
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

needs_compiler = pytest.mark.skipif(
    shutil.which("g++") is None, reason="needs g++, which compiles the kernels"
)


@cache
def _library(source: str) -> ctypes.CDLL:
    folder = Path(tempfile.mkdtemp())
    library = folder / f"{source}.so"
    shim = Path(__file__).with_name("host_device.hpp")
    command = ["g++", "-O2", "-std=c++17", "-shared", "-fPIC", "-w"]
    command += ["-x", "c++", "-include", shim, SOURCES / source, "-o", library]
    subprocess.run(command, check=True)
    loaded = ctypes.CDLL(str(library))
    shutil.rmtree(folder)
    return loaded


def _argument(clusters: Clusters) -> ClustersArgument:
    return ClustersArgument.of(clusters, lambda array: array.ctypes.data)


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def nearest_solids(
    splat_W: GaussianSplat,
    spheres: Spheres,
    max_distance: float,
    min_opacity: float = 0.0,
) -> np.ndarray:
    """Distances from the centres, vectors to the points, directions: (n, 8)."""
    clusters = solids.solid_clusters(splat_W, min_opacity, 1.0)
    rows = sphere_rows(
        spheres.p_WS, spheres.radius + max_distance, spheres.ignore_below
    )
    answer = np.full((len(rows), 8), np.nan, np.float32)
    _library(solids.SOURCE).nearest_splats(
        _argument(clusters),
        _address(clusters.order),
        ctypes.c_int(splat_W.is_surfel),
        _address(rows),
        ctypes.c_int(len(rows)),
        _address(answer),
    )
    return answer


def nearest_pixels(
    splat_W: GaussianSplat,
    spheres: Spheres,
    max_distance: float,
    sensor: DepthSensor,
    nearest_only: bool = False,
    band: int = 3200,
    room: int = 4096,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ranges and pixels of all views, (n, 6), and the kernel's rows."""
    clusters = views.view_clusters(splat_W, sensor)
    rules = views.RulesArgument.of(
        sensor,
        splat_W.is_surfel,
        nearest_only,
        views.largest_uncertainty(clusters),
        band,
        room,
    )
    reach = np.minimum(spheres.radius + max_distance, sensor.far * np.sqrt(3.0))
    rows = sphere_rows(spheres.p_WS, reach, spheres.ignore_below)
    n = len(rows)
    R_WD = sensor.R_WD(spheres.R_WL).reshape(-1, 9)
    R_WD = np.array(R_WD, np.float32, order="C")
    R_DV = views.view_rotations()
    keys = np.full((n, 6), -1)
    closest = np.full(n, -1, np.int32)
    work = np.full(1, -1, np.int32)
    lists = np.empty(rules.list_bytes, np.uint8)
    library = _library(views.SOURCE)
    places = (_address(rows), _address(R_WD), _address(R_DV), ctypes.c_int(n))
    library.depth_views(
        _argument(clusters),
        rules,
        *places,
        _address(keys),
        _address(closest),
        _address(work),
        _address(lists),
    )
    answer = np.full((n, 6, 4), np.nan, np.float32)
    library.depth_rows(rules, *places[1:], _address(keys), _address(answer))
    reach, pixel = _decoded(keys)
    return reach, pixel, answer


def _decoded(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Takes the kernel's keys apart.

    Args:
        keys: Keys of the nearest pixels, shape (n, 6), int64: in the upper half
            the range, as an integer of the same order; below it the pixel.

    Returns:
        Ranges [m], inf where nothing is seen, and pixels, -1 there.
    """
    bits = (keys >> 32).astype(np.uint32)
    positive = bits & np.uint32(1 << 31) != 0
    bits = np.where(positive, bits & np.uint32((1 << 31) - 1), ~bits)
    seen = keys != -1
    reach = np.where(seen, bits.astype(np.uint32).view(np.float32), np.inf)
    pixel = np.where(seen, keys & 0xFFFFFFFF, -1)
    return reach.astype(float), pixel
