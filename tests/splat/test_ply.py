"""Splat files: values worked by hand, round trips, and every bad input."""

import os
from pathlib import Path

import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.codecs.ply import read_ply, write_ply
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat

SURFEL = [
    *("x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"),
    *("scale_0", "scale_1", "rot_0", "rot_1", "rot_2", "rot_3"),
]


def raw_rows(names: list[str] = SURFEL, n: int = 3, kind: str = "<f4"):
    """Raw rows: splat i at (i, 2i, 3i), log scales -1, -2, rotation 2w."""
    rows = np.zeros(n, [(name, kind) for name in names])
    for name, values in {
        "x": np.arange(n),
        "y": 2 * np.arange(n),
        "z": 3 * np.arange(n),
        "f_dc_1": 1.0,
        "scale_0": -1.0,
        "scale_1": -2.0,
        "scale_2": -3.0,
        "rot_0": 2.0,
    }.items():
        if name in names:
            rows[name] = values
    return rows


def save(path: Path, rows, element: str = "vertex", **options) -> Path:
    PlyData([PlyElement.describe(rows, element)], **options).write(str(path))
    return path


def random_splat(scales: int, harmonics: int, n: int = 20) -> GaussianSplat:
    rng = np.random.default_rng(7)
    return GaussianSplat(
        p_GK=rng.normal(size=(n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=rng.uniform(1e-3, 1, (n, scales)),
        opacities=rng.uniform(0.01, 1, n),
        colors=rng.uniform(0, 1, (n, 3)),
        sh_rest=rng.normal(size=(n, harmonics, 3)),
    )


@pytest.mark.parametrize(
    "options",
    [{"byte_order": "<"}, {"byte_order": ">"}, {"text": True}],
    ids=["little", "big", "ascii"],
)
@pytest.mark.parametrize("names", [SURFEL, sorted(SURFEL)])
def test_activates_raw_parameters(tmp_path, options, names):
    splat = read_ply(save(tmp_path / "s.ply", raw_rows(names), **options))
    assert splat.is_surfel
    np.testing.assert_array_equal(splat.p_GK[2], [2, 4, 6])
    np.testing.assert_allclose(splat.scales[1], np.exp([-1, -2]), rtol=1e-6)
    np.testing.assert_allclose(splat.opacities, 0.5)
    np.testing.assert_allclose(splat.colors[0], [0.5, 0.5 + SH_C0, 0.5])
    np.testing.assert_array_equal(splat.quaternions[0], [1, 0, 0, 0])
    assert splat.sh_rest.shape == (3, 0, 3)


def test_reads_double_precision_and_normals(tmp_path):
    names = ["nx", "ny", "nz", *SURFEL, "scale_2"]
    splat = read_ply(save(tmp_path / "s.ply", raw_rows(names, kind="<f8")))
    np.testing.assert_allclose(splat.scales[0], np.exp([-1, -2, -3]), rtol=1e-6)


def test_higher_harmonics_are_channel_major(tmp_path):
    rest = [f"f_rest_{i}" for i in range(9)]
    rows = raw_rows([*SURFEL, *reversed(rest)])
    for i, name in enumerate(rest):
        rows[name] = i
    splat = read_ply(save(tmp_path / "s.ply", rows))
    # Coefficients 0, 1, 2 of red, then of green, then of blue.
    np.testing.assert_array_equal(
        splat.sh_rest[0], [[0, 3, 6], [1, 4, 7], [2, 5, 8]]
    )


def test_harmonics_that_are_left_out_are_checked(tmp_path):
    rows = raw_rows([*SURFEL, *(f"f_rest_{i}" for i in range(9))])
    path = save(tmp_path / "s.ply", rows)
    assert read_ply(path, harmonics=False).sh_rest.shape == (3, 0, 3)
    rows["f_rest_4"][2] = np.inf
    with pytest.raises(FileError, match="row 2: f_rest_4 is not finite"):
        read_ply(save(path, rows), harmonics=False)


@pytest.mark.parametrize("with_normals", [True, False])
@pytest.mark.parametrize(("scales", "harmonics"), [(2, 0), (3, 15), (2, 3)])
def test_round_trip(tmp_path, scales, harmonics, with_normals):
    splat = random_splat(scales, harmonics)
    path = tmp_path / "s.ply"
    write_ply(path, splat, with_normals)
    again = read_ply(path)
    np.testing.assert_array_equal(again.p_GK, splat.p_GK)
    np.testing.assert_array_equal(again.sh_rest, splat.sh_rest)
    for name in ("quaternions", "scales", "opacities", "colors"):
        np.testing.assert_allclose(
            getattr(again, name), getattr(splat, name), atol=1e-6, rtol=1e-5
        )
    assert os.listdir(tmp_path) == ["s.ply"]


def test_uncertainty_is_one_more_property_that_others_pass_over(tmp_path):
    splat = random_splat(2, 0)
    path = tmp_path / "s.ply"
    write_ply(path, splat)
    assert read_ply(path).uncertainty is None
    names = PlyData.read(str(path))["vertex"].data.dtype.names
    uncertain = splat.with_uncertainty(np.linspace(0, 0.05, 20))
    write_ply(path, uncertain)
    np.testing.assert_array_equal(
        read_ply(path).uncertainty, uncertain.uncertainty
    )
    rows = PlyData.read(str(path))["vertex"].data
    assert rows.dtype.names == (*names, "uncertainty")


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (-0.001, "uncertainty of splat 1 is negative"),
        (np.nan, "row 1: uncertainty is not finite"),
        (np.inf, "row 1: uncertainty is not finite"),
    ],
)
def test_rejects_bad_uncertainty(tmp_path, value, problem):
    rows = raw_rows([*SURFEL, "uncertainty"])
    rows["uncertainty"][1] = value
    with pytest.raises(FileError, match=problem):
        read_ply(save(tmp_path / "s.ply", rows))


def test_writes_inria_order(tmp_path):
    write_ply(tmp_path / "s.ply", random_splat(3, 15))
    element = PlyData.read(str(tmp_path / "s.ply"))["vertex"]
    assert [p.name for p in element.properties] == [
        *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"),
        *(f"f_rest_{i}" for i in range(45)),
        *("opacity", "scale_0", "scale_1", "scale_2"),
        *("rot_0", "rot_1", "rot_2", "rot_3"),
    ]


def test_extreme_but_finite_parameters_survive(tmp_path):
    rows = raw_rows()
    rows["opacity"] = [-200, 200, 0]
    rows["scale_1"] = -300
    splat = read_ply(save(tmp_path / "s.ply", rows))
    assert (splat.opacities > 0).all()
    assert (splat.scales > 0).all()
    write_ply(tmp_path / "again.ply", splat)
    assert (read_ply(tmp_path / "again.ply").opacities <= 1).all()


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("x", np.nan, "row 1: x is not finite"),
        ("opacity", np.inf, "row 1: opacity is not finite"),
        ("scale_1", -np.inf, "row 1: scale_1 is not finite"),
        ("scale_0", 1e4, "scales of splat 1 is not finite"),
        ("rot_0", 0, "row 1: the quaternion is zero"),
    ],
)
def test_rejects_bad_values(tmp_path, name, value, problem):
    rows = raw_rows()
    rows[name][1] = value
    path = save(tmp_path / "s.ply", rows)
    with pytest.raises(FileError, match=problem) as caught:
        read_ply(path)
    assert caught.value.path == path
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        ([n for n in SURFEL if n != "rot_3"], "rot_3 is missing"),
        ([n for n in SURFEL if n != "scale_0"], "scale_0 is missing"),
        ([n for n in SURFEL if n != "scale_1"], "scale_1 is missing"),
        (["x", "y", "z"], "opacity, scale_0, scale_1, rot_0"),
        ([*SURFEL, "scale_2", "scale_3"], "4 scales"),
        ([*SURFEL, "f_rest_0", "f_rest_1"], "2 f_rest"),
        ([*SURFEL, "f_rest_1"], "f_rest_0 is missing"),
    ],
)
def test_rejects_wrong_properties(tmp_path, names, problem):
    with pytest.raises(FileError, match=problem):
        read_ply(save(tmp_path / "s.ply", raw_rows(names)))


def test_rejects_wrong_property_types(tmp_path):
    rows = raw_rows().astype(
        [(n, "u1" if n == "opacity" else "<f4") for n in SURFEL]
    )
    with pytest.raises(FileError, match="opacity has type uint8"):
        read_ply(save(tmp_path / "integer.ply", rows))
    rows = np.empty(1, [(n, "O" if n == "y" else "<f4") for n in SURFEL])
    rows["y"][0] = np.zeros(2)
    with pytest.raises(FileError, match="property y is a list"):
        read_ply(save(tmp_path / "list.ply", rows))


@pytest.mark.parametrize("text", [True, False])
def test_rejects_counts_that_do_not_match(tmp_path, text):
    whole = save(tmp_path / "s.ply", raw_rows(), text=text).read_bytes()
    path = tmp_path / "bad.ply"
    for count in (2, 4, 10**15):
        path.write_bytes(whole.replace(b"vertex 3", b"vertex %d" % count, 1))
        with pytest.raises(FileError, match=r"row|declares"):
            read_ply(path)
    path.write_bytes(whole[:-20])
    with pytest.raises(FileError, match="row"):
        read_ply(path)


@pytest.mark.parametrize(
    "content",
    [b"", b"ply\n", b"solid stl", b"\x89PNG\r\n\x1a\n\0\0", b"ply\nformat x\n"],
)
def test_rejects_what_is_no_ply(tmp_path, content):
    path = tmp_path / "s.ply"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"s\.ply: unreadable as PLY"):
        read_ply(path)


def test_rejects_missing_empty_and_foreign(tmp_path):
    with pytest.raises(FileError, match="No such file"):
        read_ply(tmp_path / "nowhere.ply")
    with pytest.raises(FileError, match="irectory"):
        read_ply(tmp_path)
    with pytest.raises(FileError, match="holds no splats"):
        read_ply(save(tmp_path / "empty.ply", raw_rows(n=0)))
    with pytest.raises(FileError, match="no element 'vertex'"):
        read_ply(save(tmp_path / "chunk.ply", raw_rows(), element="chunk"))


def test_failed_write_leaves_nothing(tmp_path):
    target = tmp_path / "folder"
    target.mkdir()
    (target / "kept").touch()
    with pytest.raises(FileError, match="cannot be written"):
        write_ply(target, random_splat(2, 0))
    assert os.listdir(tmp_path) == ["folder"]
    with pytest.raises(FileError, match=r"Not a directory|File exists"):
        write_ply(target / "kept" / "s.ply", random_splat(2, 0))


@pytest.mark.parametrize(
    ("name", "count", "scales", "harmonics"),
    [
        ("splats/table_0001.ply", 60_000, 2, 0),
        ("splats/table_0001_noise.ply", 61_000, 2, 0),
        ("redkitchen/redkitchen.ply", 50_000, 2, 0),
        ("formats/leica-sofort-top8192.ply", 8192, 3, 15),
        ("formats/test-splat.3-points-from-train.ply", 3, 3, 15),
    ],
)
def test_reads_real_files(shared_data, name, count, scales, harmonics):
    splat = read_ply(shared_data / name)
    assert splat.scales.shape == (count, scales)
    assert splat.sh_rest.shape == (count, harmonics, 3)


def test_property_order_does_not_matter(shared_data):
    folder = shared_data / "formats"
    a = read_ply(folder / "leica-sofort-top8192.ply")
    b = read_ply(folder / "leica-sofort-top8192.derived-inria-order.ply")
    assert a.content_hash == b.content_hash
