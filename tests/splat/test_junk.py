"""Junk in splats: what is planted goes, and what is thin stays."""

import numpy as np
import pytest
from planted_splat import PLANTED, splats_at, with_junk

from remosplat_drake.base.resources import models_dir
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.cleaning.junk import (
    BEFORE,
    FAINT,
    FEW,
    FLOATER,
    KEPT,
    SKY,
    UNSEEN,
    find_junk,
)
from remosplat_drake.splat.cleaning.views import Views
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

TABLE, BOOKSHELF = (
    models_dir() / f"scenes/{name}/splat.ply" for name in ("table", "bookshelf")
)


def names_of(junk) -> np.ndarray:
    return np.array(junk.names, object)[junk.reason]


def plate(height: float, n: int = 40, spacing: float = 0.02) -> GaussianSplat:
    """A square of n times n discs in the plane z = height."""
    u = spacing * (np.arange(n) - 0.5 * n)
    x, y = (axis.ravel() for axis in np.meshgrid(u, u))
    splat = splats_at(
        np.stack([x, y, np.full(n * n, height)], axis=1),
        [spacing] * 2,
        np.random.default_rng(0),
    )
    upright = np.tile([1.0, 0, 0, 0], (n * n, 1))
    return GaussianSplat(**splat.arrays() | {"quaternions": upright})


def chain(start, end, spacing: float, size: float) -> GaussianSplat:
    """Small splats on a line."""
    start, end = np.array(start, float), np.array(end, float)
    n = int(np.linalg.norm(end - start) / spacing) + 1
    share = np.linspace(0, 1, n)[:, None]
    rng = np.random.default_rng(1)
    return splats_at(start + share * (end - start), [size] * 2, rng)


@pytest.mark.parametrize("scene", [TABLE, BOOKSHELF])
def test_what_is_planted_is_found_and_nothing_else(scene):
    splat, kinds = with_junk(read_splat(scene))
    found = names_of(find_junk(splat))
    for kind, count in PLANTED.items():
        assert np.count_nonzero(found[kinds == kind] != KEPT) == count, kind
    assert (found[kinds == KEPT] == KEPT).all()
    # By name all but a few: a needle that is large enough is a giant, too.
    assert (found == kinds).mean() > 0.999


def test_distances_are_those_of_the_clean_scene_again():
    clean = read_splat(TABLE).with_uncertainty(None)
    splat, _ = with_junk(clean)
    rng = np.random.default_rng(3)
    lower, upper = clean.p_GK.min(axis=0), clean.p_GK.max(axis=0)
    spheres = Spheres.at(rng.uniform(lower, upper, (500, 3)))

    def distances(splat):
        return SphereToEllipsoidField(splat).clearances(spheres).distance

    expected = distances(clean)
    # Giants fill much of the space.
    assert np.quantile(expected - distances(splat), 0.75) > 0.1
    kept = splat.select(find_junk(splat).is_kept)
    np.testing.assert_allclose(distances(kept), expected, atol=1e-9)


@pytest.mark.parametrize("is_tied", [True, False])
def test_a_wire_stays(is_tied):
    """Of splats as thin as 2 mm, between two plates or in the air."""
    gap = 0.0 if is_tied else 0.15
    wire = chain([0, 0, gap], [0.1, 0, 1 - gap], 0.006, 0.002)
    plates = plate(0.0).joined_with(plate(1.0))
    junk = find_junk(plates.joined_with(wire))
    assert junk.is_kept.all()


def test_thin_boards_stay():
    """Each of them is a group of its own."""
    boards = [plate(0.3 * k, n=12 + k) for k in range(6)]
    splat = boards[0]
    for board in boards[1:]:
        splat = splat.joined_with(board)
    assert find_junk(splat).is_kept.all()


def test_a_large_splat_of_a_bare_wall_stays():
    """Training covers what has no texture with few splats."""
    bare = plate(1.0, n=4, spacing=0.25)
    splat = plate(0.0).joined_with(bare)
    wall = splats_at([[0.4, 0.0, 0.5]], [0.3, 0.3], np.random.default_rng(0))
    facing_x = np.sqrt([[0.5, 0, 0.5, 0]])
    wall = GaussianSplat(**wall.arrays() | {"quaternions": facing_x})
    assert find_junk(splat.joined_with(wall)).is_kept.all()


def test_a_group_is_a_floater_by_its_number():
    few, enough = FEW - 1, FEW
    rng = np.random.default_rng(0)
    for count, name in ((few, FLOATER), (enough, KEPT)):
        p_GK = [0, 0, 0.5] + 0.003 * rng.normal(size=(count, 3))
        blob = splats_at(p_GK, [0.003] * 2, rng)
        found = names_of(find_junk(plate(0.0).joined_with(blob)))
        assert (found[-count:] == name).all()
        assert (found[:-count] == KEPT).all()


def test_a_room_around_a_close_up_is_no_sky():
    """The object has most of the splats; a floor leads to the walls."""
    close_up = plate(0.1, n=60, spacing=0.004)
    floor = plate(0.0, n=60, spacing=0.1)
    assert find_junk(close_up.joined_with(floor)).is_kept.all()
    far = plate(60.0, n=20, spacing=1.0)
    found = names_of(find_junk(close_up.joined_with(floor).joined_with(far)))
    assert (found[-400:] == SKY).all() and (found[:-400] == KEPT).all()


def test_the_unit_does_not_matter():
    splat, _ = with_junk(read_splat(TABLE).select(slice(0, None, 4)))
    scaled = GaussianSplat(
        **splat.arrays()
        | {"p_GK": 64 * splat.p_GK, "scales": 64 * splat.scales}
    )
    np.testing.assert_array_equal(
        find_junk(scaled).reason, find_junk(splat).reason
    )


def looking_down(height: float) -> Views:
    """One camera over the origin that sees 2 height times 2 height."""
    X_GC = np.diag([1.0, -1, -1, 1])
    X_GC[2, 3] = height
    K = np.array([[100.0, 0, 100], [0, 100, 100], [0, 0, 1]])
    return Views(X_GC[None], K[None], np.array([[200.0, 200.0]]))


def test_cameras_tell_what_hangs_before_them_and_what_none_has_seen():
    scene = plate(0.0, n=60)
    before = plate(1.93, n=6, spacing=0.002)
    unseen = plate(2.5, n=6, spacing=0.01)
    lamp = plate(1.0, n=6, spacing=0.01)
    splat = scene.joined_with(before).joined_with(unseen).joined_with(lamp)
    assert find_junk(splat).is_kept.all()
    found = names_of(find_junk(splat, looking_down(2.0)))
    kinds = np.repeat([KEPT, BEFORE, UNSEEN, KEPT], [3600, 36, 36, 36])
    np.testing.assert_array_equal(found, kinds)


def test_few_splats_are_left_alone():
    rng = np.random.default_rng(0)
    one = splats_at(np.zeros((1, 3)), [0.1, 0.1], rng)
    assert find_junk(one).is_kept.all()
    faint = splats_at(np.zeros((3, 3)), [0.1, 0.1], rng, 0.01)
    assert (names_of(find_junk(faint)) == FAINT).all()
