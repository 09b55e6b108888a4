"""Rods of 3 to 20 mm in the live map: none of them is free."""

import dataclasses as dc
from functools import cache

import numpy as np
import pytest
from laden_table import joined
from rods import ALL, CONFIG, DIAMETERS, beside, inside, pitch, rods, views

from apps.studies.map_bound.judge import SEEN_BY, Sight, times_seen
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import sensor_noise
from remosplat_drake.mapping.map_builder import build_map
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import FREE, UNSEEN
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap

TRUTH = SignedDistanceField(ALL)
NUMBERS = range(len(DIAMETERS))
NEAR, FARTHER, FAR, AFAR = 0.6, 0.9, 1.2, 2.5
"""Distances of the cameras from the rods [m]."""

NOISY = pytest.param("realsense_d435", marks=pytest.mark.slow)


def a_map(capture: Capture, **options) -> SceneMap:
    """A map in which unseen space is an obstacle."""
    return build_map(
        capture,
        CONFIG,
        version=1,
        parent=None,
        frames=tuple(f"frame_{i}" for i in range(len(capture))),
        time=0.0,
        make_field=SphereToEllipsoidField,
        unseen_is_solid=True,
        **options,
    )


def fields(dut: SceneMap) -> tuple[DistanceField, DistanceField]:
    """The distances to all that is solid, and to the discs alone."""
    assert isinstance(dut.field, CompositeDistanceField)
    return dut.field, dut.field.parts[0]


def distances(field: DistanceField, p_W: np.ndarray) -> np.ndarray:
    return field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))


@pytest.mark.parametrize("sensor", ["none", NOISY])
@pytest.mark.parametrize(
    "distance",
    [
        pytest.param(NEAR, marks=pytest.mark.slow),
        pytest.param(FARTHER, marks=pytest.mark.slow),
        FAR,
    ],
)
def test_no_rod_is_nearer_than_the_map_says(distance, sensor):
    """Discs subtract what they do not know."""
    capture = views(distance, sensor)
    dut = a_map(capture)
    sight = Sight(ALL, views(distance), capture.depth, sensor_noise(sensor))
    for number in NUMBERS:
        p_W, diameter = beside(number), DIAMETERS[number]
        truth = TRUTH.clearances(Spheres.at(p_W))
        count = times_seen(truth.p_WC, truth.direction_W, sight)
        assert (count > len(capture) / 2).sum() > 100
        assert (dut.coverage.states_at(inside(number)) != FREE).all()
        if diameter < pitch(distance):
            continue  # Pixels miss parts of it.
        for field in fields(dut):
            over = distances(field, p_W) - truth.distance
            assert over[count > len(capture) / 2].max() <= 0
            # Its sides lie between the pixels of the few views that see them,
            # and no view has seen its back.
            assert over[count >= SEEN_BY].max() <= 2 * pitch(distance)
            assert over.max() < diameter + pitch(distance)


@cache
def glimpse() -> tuple[Capture, np.ndarray]:
    """One view meets the thinnest rod here and there, the others miss it.

    Returns:
        The views, and the points that the first has measured on the rod, shape
        (n, 3) [m].
    """
    nothing = views(FAR, scene=rods())
    depth = nothing.depth.copy()
    depth[0] = views(FAR, scene=rods(0)).depth[0]
    on_rod = depth[0] < nothing.depth[0] - 0.1
    capture = dc.replace(nothing, depth=depth)
    return capture, capture.points_W(0)[on_rod]


def test_where_a_single_pixel_has_met_a_rod_nothing_is_free():
    capture, measured = glimpse()
    # Of 0.4 m, less than every second row of pixels.
    assert 20 < len(measured) < 0.5 * 0.4 / pitch(FAR) + 20
    dut = a_map(capture)
    assert (dut.coverage.states_at(measured) == UNSEEN).all()
    solid, _ = fields(dut)
    assert distances(solid, measured).max() < 0


@pytest.mark.slow
def test_views_with_fine_pixels_tell_that_it_is_free_after_all():
    capture, measured = glimpse()
    dut = a_map(joined(capture, views(NEAR, scene=rods())))
    assert (dut.coverage.states_at(measured) == FREE).mean() > 0.9


def before_a_wall(rod_too: bool) -> tuple[Capture, np.ndarray]:
    """Two parallel views, 0.18 m apart, of a wall and a rod of one pixel.

    A pixel is 3.6 mm wide on the rod, 0.9 m away: the cameras are 50 pixels
    apart there.

    Returns:
        The views, and the points measured on the rod, shape (n, 3) [m].
    """
    X_WC = np.tile(np.eye(4), (2, 1, 1))
    X_WC[:, :3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    X_WC[:, :3, 3] = [[0, 0.09, 0.6], [0, -0.09, 0.6]]
    on_rod = np.zeros((2, 240, 320), bool)
    on_rod[0, 90:150, 160 + 25] = on_rod[1, 90:150, 160 - 25] = True
    capture = Capture(
        K=np.tile([[250.0, 0, 160], [0, 250, 120], [0, 0, 1]], (2, 1, 1)),
        X_WC=X_WC,
        rgb=np.full((*on_rod.shape, 3), 128, np.uint8),
        depth=np.where(on_rod & rod_too, 0.9, 1.35).astype(np.float32),
    )
    there = dc.replace(capture, depth=np.where(on_rod, 0.9, 0.0))
    measured = [there.points_W(i)[on_rod[i]] for i in (0, 1)]
    return capture, np.concatenate(measured)


def test_a_rod_of_one_pixel_in_two_views_is_there():
    wall, measured = before_a_wall(rod_too=False)
    # It stands at one place: half a pixel to the right of the middle.
    np.testing.assert_allclose(measured[:, 0], 0.9, rtol=1e-6)
    np.testing.assert_allclose(measured[:, 1], -0.0018, atol=1e-6)
    without = a_map(wall)
    assert (without.coverage.states_at(measured) == FREE).all()
    dut = a_map(before_a_wall(rod_too=True)[0])
    assert (dut.coverage.states_at(measured) != FREE).all()
    _, discs = fields(dut)
    assert distances(discs, measured).max() <= 0
    assert dut.splat_W is not None and dut.splat_W.uncertainty is not None
    on_rod = np.abs(dut.splat_W.p_GK[:, 0] - 0.9) < 0.02
    assert on_rod.sum() > 10
    # Half a pixel at least.
    assert (dut.splat_W.uncertainty[on_rod] > 0.0018).all()


@cache
def near_map() -> SceneMap:
    return a_map(views(NEAR))


def check_that_all_rods_are_there(dut: SceneMap) -> None:
    for number in NUMBERS:
        p_W = beside(number)
        truth = distances(TRUTH, p_W)
        for field in fields(dut):
            assert (distances(field, p_W) < truth + DIAMETERS[number]).all()
        assert (dut.coverage.states_at(inside(number)) != FREE).all()


def test_frames_from_afar_take_nothing_away_that_near_ones_saw():
    check_that_all_rods_are_there(a_map(joined(views(NEAR), views(AFAR))))


@pytest.mark.slow
def test_nor_do_they_from_a_splat_and_what_its_capture_saw():
    near = near_map()
    dut = a_map(views(AFAR), base=near.splat_W, base_seen=near.coverage)
    check_that_all_rods_are_there(dut)


@pytest.mark.slow
def test_near_frames_take_away_what_has_gone():
    near = near_map()
    gone = a_map(
        views(NEAR, scene=rods()), base=near.splat_W, base_seen=near.coverage
    )
    for number in NUMBERS:
        _, discs = fields(gone)
        assert distances(discs, inside(number)).min() > 0.1
