"""A splat as a glTF of instances, read as a viewer reads it."""

import base64
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.colors import linear_rgb
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.instanced_splat import (
    InstancedSplat,
    double_cone,
    quaternions,
)

DTYPES = {5126: np.float32, 5122: np.int16, 5123: np.uint16}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def scattered(axes: int, n: int = 40) -> GaussianSplat:
    generator = np.random.default_rng(axes)
    return GaussianSplat(
        p_GK=generator.uniform([1, -2, 0], [4, 2, 1], (n, 3)),
        quaternions=generator.normal(size=(n, 4)),
        scales=generator.uniform(0.01, 0.1, (n, axes)),
        opacities=np.full(n, 0.9),
        colors=generator.uniform(0, 1, (n, 3)),
    )


def document_of(mesh) -> dict:
    return json.loads(mesh.source().in_memory().mesh_file.contents())


def read(document: dict, index: int) -> np.ndarray:
    """The numbers of an accessor, as glTF says that they are meant."""
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    uri = document["buffers"][view["buffer"]]["uri"]
    data = base64.b64decode(uri.split(",")[1])
    kind = DTYPES[accessor["componentType"]]
    width = WIDTHS[accessor["type"]]
    values = np.frombuffer(
        data, kind, accessor["count"] * width, view["byteOffset"]
    ).reshape(-1, width)
    if accessor["normalized"]:
        values = values / np.iinfo(kind).max
    return values


@pytest.mark.parametrize("axes", [2, 3])
def test_discs_are_where_the_splats_are(axes):
    splat = scattered(axes)
    document = document_of(InstancedSplat(splat, n_sigma=2.0).surfels())
    root, node = document["nodes"]
    # Meshcat turns a file by a right angle about x, and the root turns back.
    np.testing.assert_allclose(
        root["rotation"], [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    )
    attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    values = {k: read(document, i) for k, i in attributes.items()}
    unit = node["scale"][0]
    p_GK = node["translation"] + unit * values["TRANSLATION"]
    np.testing.assert_allclose(p_GK, splat.p_GK, atol=1e-4)
    np.testing.assert_allclose(
        values["_COLOR_0"], linear_rgb(splat.colors), atol=1e-5
    )
    # A rim's points along the axes of a disc are 2 sigma away.
    size = unit * values["SCALE"]
    largest = -np.sort(-splat.scales, axis=1)[:, :2]
    np.testing.assert_allclose(size[:, :2], 2 * largest, atol=1e-4)
    for i, (x, y, z, w) in enumerate(values["ROTATION"]):
        R_GD = rotation(w, x, y, z)
        order = np.argsort(-splat.scales[i], kind="stable")
        np.testing.assert_allclose(
            R_GD[:, :2], splat.R_GK[i][:, order[:2]], atol=2e-4
        )


def rotation(w, x, y, z) -> np.ndarray:
    """As in any book, so that it shares nothing with the code."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_points_share_the_discs_data():
    dut = InstancedSplat(scattered(2), n_sigma=2.0)
    surfels, points = document_of(dut.surfels()), document_of(dut.points(0.01))
    assert surfels["buffers"][0] == points["buffers"][0]
    primitive = points["meshes"][0]["primitives"][0]
    corners = read(points, primitive["attributes"]["POSITION"])
    radius = np.linalg.norm(corners * points["nodes"][1]["scale"], axis=1)
    np.testing.assert_allclose(radius, 0.01, rtol=1e-5)


def test_a_disc_takes_26_bytes():
    few, many = (
        document_of(InstancedSplat(scattered(2, n), 1.6).surfels())
        for n in (40, 1040)
    )
    sizes = [d["buffers"][0]["byteLength"] for d in (few, many)]
    assert sizes[1] - sizes[0] == 26_000


def test_a_double_cone_is_closed_and_looks_outward():
    vertices, faces = double_cone(8)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = 8 / 2 * np.sin(2 * np.pi / 8)
    volume = np.einsum("fi,fi->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(2 * area / 3)


@settings(max_examples=100)
@given(st.tuples(*4 * [st.floats(-1, 1)]).filter(lambda q: np.any(q)))
def test_quaternions_turn_as_the_matrices_do(wxyz):
    wxyz = np.array(wxyz) / np.abs(wxyz).max()
    wxyz /= np.linalg.norm(wxyz)
    R = rotation(*wxyz)
    x, y, z, w = quaternions(R[None])[0]
    np.testing.assert_allclose(rotation(w, x, y, z), R, atol=1e-12)
