"""Splat files of all formats: round trips, real files, and recognition.

How far a round trip may be off follows from each format's number of bits. A
quaternion of smallest-three packing with an error e in each of three
components is off by less than sqrt(12) e: the fourth component is at least
1/2, so its error is at most (|x| + |y| + |z|) e / w <= 3 e.
"""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from optional import HAS_TORCH, needs_torch
from scipy.spatial import cKDTree
from toy_splats import random_splat

from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.codecs.conversion_error import conversion_error
from remosplat_drake.splat.codecs.ply import read_ply, write_ply
from remosplat_drake.splat.codecs.spz import read_spz, write_spz
from remosplat_drake.splat.formats import (
    ANTIMATTER,
    CHECKPOINT,
    COMPRESSED_PLY,
    FORMATS,
    PLY,
    SOG,
    SPZ,
    format_of_file,
    format_of_name,
    read_splat,
    write_splat,
)

EACH = pytest.mark.parametrize(
    "format_",
    [
        pytest.param(format_, id=format_.title, marks=marks)
        for format_ in FORMATS
        for marks in [needs_torch if format_ is CHECKPOINT else ()]
    ],
)
EXACT = 1e-6

splats = st.builds(
    random_splat,
    scales=st.sampled_from([2, 3]),
    harmonics=st.sampled_from([0, 3, 15]),
    n=st.integers(1, 300),
    seed=st.integers(0, 2**32 - 1),
)


def rotation_bound(component_error: float) -> float:
    """Largest angle that smallest-three packing can turn by [rad]."""
    return 4 * np.arcsin(np.sqrt(12) * component_error / 2)


def extent(values: np.ndarray) -> float:
    """The largest extent of any column."""
    return float(np.ptp(values, axis=0).max())


def bounds(format_, splat) -> tuple[float, float, float, float]:
    """Position [m], ratio of scales, rotation [rad], opacity: at most."""
    byte = 1 / 510 + EXACT
    logarithms = np.log(splat.scales)
    if format_ is ANTIMATTER:
        # Half a step of 1/128; a component of 1 is cut to 127/128.
        chord = np.sqrt(3 / 256**2 + 1 / 128**2)
        return EXACT, EXACT, 4 * np.arcsin(chord / 2), byte
    if format_ is SPZ:
        position = np.sqrt(3) * 2.0**-13
        rotation = rotation_bound(np.sqrt(0.5) / 511 / 2)
        return position + EXACT, np.expm1(1 / 32) + EXACT, rotation, byte
    if format_ is COMPRESSED_PLY:
        step = 1 / 1023 / 2
        rotation = rotation_bound(np.sqrt(2) * step)
        position = np.sqrt(3) * extent(splat.p_GK) * step
        scale = np.expm1(extent(logarithms) * step)
        return position + EXACT, scale + EXACT, rotation, byte
    if format_ is SOG:
        p_log = np.sign(splat.p_GK) * np.log1p(np.abs(splat.p_GK))
        step = extent(p_log) / 65535 / 2
        stretch = 1 + np.abs(splat.p_GK).max()
        rotation = rotation_bound(np.sqrt(2) / 255 / 2)
        # A codebook's steps are at most twice as wide as even ones.
        scale = np.expm1((logarithms.max() + 10) / 255)
        return 2 * step * stretch + EXACT, scale, rotation, byte
    return EXACT, EXACT, 4 * EXACT, EXACT


@EACH
@given(splat=splats)
@settings(max_examples=8)
def test_round_trip_within_the_format_s_steps(format_, splat, tmp_path_factory):
    path = tmp_path_factory.mktemp("splat") / f"ckpt_1_rank0{format_.suffix}"
    write_splat(path, splat)
    again = read_splat(path)
    assert again.is_surfel == splat.is_surfel
    written = format_.as_written(splat)
    error = conversion_error(written, again)
    position, scale, rotation, opacity = bounds(format_, splat)
    assert error.position.max() <= position
    assert error.scale.max() <= scale
    assert error.rotation.max() <= rotation
    assert error.opacity.max() <= opacity
    np.testing.assert_allclose(again.colors, written.colors, atol=0.004)
    if again.sh_rest.shape[1]:
        atol = 1 / 64 + EXACT
        np.testing.assert_allclose(again.sh_rest, written.sh_rest, atol=atol)


@EACH
@pytest.mark.parametrize("scales", [2, 3])
def test_harmonics_may_be_left_out(format_, scales, tmp_path):
    path = tmp_path / f"ckpt_1_rank0{format_.suffix}"
    write_splat(path, random_splat(scales, 3))
    without = read_splat(path, harmonics=False)
    assert without.sh_rest.shape == (20, 0, 3)
    expected = read_splat(path).without_harmonics()
    assert without.content_hash == expected.content_hash


@EACH
def test_what_a_format_says_it_loses_is_what_it_loses(format_, tmp_path):
    splat = random_splat(2, 3, n=300)
    path = tmp_path / f"s{format_.suffix}"
    write_splat(path, splat)
    again = read_splat(path)
    error = conversion_error(format_.as_written(splat), again)
    assert bool(format_.loss) == (error.rotation.max() > 1e-5)
    assert ("harmonics" in format_.loss) == (again.sh_rest.shape[1] == 0)
    assert format_.keeps_surfels == format_.read(path).is_surfel or (
        format_ is CHECKPOINT
    )


def test_files_are_the_same_every_time(tmp_path):
    splat = random_splat(2, 3, n=300)
    for format_ in FORMATS:
        if format_ is CHECKPOINT and not HAS_TORCH:
            continue
        paths = [tmp_path / f"{name}{format_.suffix}" for name in "ab"]
        for path in paths:
            write_splat(path, splat)
        assert paths[0].read_bytes() == paths[1].read_bytes(), format_.title


@EACH
def test_content_counts_more_than_the_name(format_, tmp_path):
    path = tmp_path / f"s{format_.suffix}"
    write_splat(path, random_splat(2))
    assert format_of_file(path) is format_
    # Only .splat has nothing to be known by.
    other = path.rename(tmp_path / "s.splat")
    assert format_of_file(other) is format_
    other = other.rename(tmp_path / "unnamed")
    if format_ is ANTIMATTER:
        with pytest.raises(FileError, match=r"valid: \.compressed\.ply, \.ply"):
            read_splat(other)
    else:
        assert len(read_splat(other)) == 20


def test_names_choose_what_is_written(tmp_path):
    assert format_of_name(tmp_path / "A.PLY") is PLY
    assert format_of_name(tmp_path / "a.compressed.ply") is COMPRESSED_PLY
    with pytest.raises(
        FileError, match=r"a\.obj: unknown suffix; valid: .*\.spz"
    ):
        write_splat(tmp_path / "a.obj", random_splat())


def test_discs_that_were_given_a_thickness_are_discs_again(tmp_path):
    """As viewers' exporters write a third scale of log(tiny) to a PLY."""
    thick = random_splat(3)
    scales = thick.scales.copy()
    scales[:, 2] = 1e-7
    path = tmp_path / "s.ply"
    write_ply(path, dc.replace(thick, scales=scales))
    assert read_ply(path).scales.shape == (20, 3)
    assert read_splat(path).is_surfel
    scales[3, 2] = 2e-7
    write_ply(path, dc.replace(thick, scales=scales))
    assert not read_splat(path).is_surfel


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("version", [3, 4])
def test_spz_of_every_degree(version, degree, tmp_path):
    splat = random_splat(3, (degree + 1) ** 2 - 1)
    path = tmp_path / "s.spz"
    write_spz(path, splat, version)
    again = read_spz(path)
    np.testing.assert_allclose(again.sh_rest, splat.sh_rest, atol=1 / 256)
    assert (path.read_bytes()[:4] == b"NGSP") == (version == 4)


def test_spz_cannot_reach_everywhere(tmp_path):
    splat = random_splat()
    p_GK = splat.p_GK.copy()
    p_GK[4, 1] = 2048
    far = dc.replace(splat, p_GK=p_GK)
    with pytest.raises(FileError, match=r"splat 4 is farther .* 2048 m"):
        write_spz(tmp_path / "s.spz", far)
    with pytest.raises(FileError, match="5 higher harmonics"):
        write_spz(tmp_path / "s.spz", random_splat(3, 5))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".splat", ".spz"])
def test_real_files_of_one_model_agree(shared_data, suffix):
    stem = "test-splat.3-points-from-train"
    ply = read_splat(shared_data / "formats" / f"{stem}.ply")
    other = read_splat(shared_data / "formats" / f"{stem}{suffix}")
    error = conversion_error(ply, other)
    position, scale, rotation, opacity = bounds(
        format_of_name(Path(suffix)), ply
    )
    assert error.position.max() <= position
    assert error.scale.max() <= scale
    assert error.rotation.max() <= rotation
    # The writer of this .splat cut where ours rounds.
    assert error.opacity.max() <= 2 * opacity
    np.testing.assert_allclose(other.colors, ply.colors, atol=0.01)


def test_a_real_sog_agrees_with_its_ply(shared_data):
    ply = read_splat(shared_data / "formats" / "leica-sofort-top8192.ply")
    sog = read_splat(shared_data / "formats" / "leica-sofort-top8192.sog")
    _, match = cKDTree(ply.p_GK).query(sog.p_GK)
    assert len(set(match)) == len(sog) == len(ply)
    ply = ply.select(match)
    error = conversion_error(ply, sog)
    assert error.position.max() < 2e-3
    assert np.median(error.scale) < 0.02
    assert error.rotation.max() < 0.04
    assert error.opacity.max() < 5e-3
    # The palette of harmonics: as good in each of the 15.
    for k in range(15):
        pair = ply.sh_rest[:, k].ravel(), sog.sh_rest[:, k].ravel()
        assert np.corrcoef(pair)[0, 1] > 0.999


def test_a_real_spz_of_version_2(shared_data):
    splat = read_splat(shared_data / "formats" / "leica-sofort-top8192.spz")
    assert len(splat) == 8192
    assert splat.sh_rest.shape == (8192, 15, 3)
    assert np.abs(splat.p_GK).max() < 0.25
