"""Maps of a table that things come to and go from."""

import dataclasses as dc

import numpy as np
import pytest
from laden_table import THING, joined, table

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.rendering.sensor_noise import (
    sensor_noise,
    with_noise,
)
from remosplat_drake.mapping.map_builder import build_map
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.mapping.store.map_file import open_map, write_map
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN
from remosplat_drake.signals.scene_map import SceneMap

CONFIG = MappingConfig(
    volume_lower=[0, -1, 0], volume_upper=[2, 1, 1.5], voxel=0.05, discs=8000
)
BESIDE_THING = Spheres.at([[1, 0.2, 0.55], [1, -0.2, 0.55], [1, 0, 0.75]])


def a_map(capture, config=CONFIG, **options) -> SceneMap:
    return build_map(
        capture,
        config,
        version=2,
        parent=1,
        frames=tuple(f"frame_{i}" for i in range(len(capture))),
        time=3.0,
        make_field=SphereToEllipsoidField,
        **options,
    )


ASIDE, ACROSS = [0.0, -1.2, 0.9], [0.0, 1.4, 0.4]
NEARLY = [0.02, 0.0, 0.0]


def moved(capture, shift: list[float]):
    """The first view, by a camera that believes to be elsewhere [m]."""
    X_WC = capture.X_WC[:1].copy()
    X_WC[:, :3, 3] += shift
    return dc.replace(capture.select(np.array([0])), X_WC=X_WC)


def distances(scene_map: SceneMap, spheres: Spheres) -> np.ndarray:
    return scene_map.field.clearances(spheres).per_sphere(len(spheres))


def truth(*things) -> np.ndarray:
    field = SignedDistanceField(table(*things))
    return field.clearances(BESIDE_THING).per_sphere(len(BESIDE_THING))


@pytest.fixture(scope="module")
def bare_map(bare) -> SceneMap:
    return a_map(bare)


@pytest.fixture(scope="module")
def laden_map(laden) -> SceneMap:
    return a_map(laden)


@pytest.fixture(scope="module")
def solid_map(laden) -> SceneMap:
    """The map of the laden table whose unseen space is solid."""
    return a_map(laden, unseen_is_solid=True)


@pytest.fixture(scope="module")
def map_with_thing(bare, laden) -> SceneMap:
    """The map of a table that the thing has come to."""
    return a_map(joined(bare, laden))


def test_a_map_tells_what_it_is_made_of(laden):
    stages = []
    dut = a_map(laden, report=lambda *stage: stages.append(stage))
    assert (dut.version, dut.parent, dut.time) == (2, 1, 3.0)
    assert dut.frames == ("frame_0", "frame_1", "frame_2")
    assert dut.quality.startswith("3 frames, ")
    assert sum(tile.vertices.shape[1] for tile in dut.tiles) > 1000
    assert {stage for stage, _, _ in stages} == {
        "comparing frames",
        "surfels",
        "refining",
        "bounding",
        "finding what was seen",
    }
    assert all(0 <= done <= total for _, done, total in stages)


@pytest.mark.parametrize("effort", ["quick", "full"])
def test_distances_are_those_of_the_scene(laden, effort):
    dut = a_map(laden, effort=effort)
    np.testing.assert_allclose(
        distances(dut, BESIDE_THING), truth(THING), atol=0.01
    )


@pytest.mark.parametrize("sensor", ["none", "kinect"])
def test_a_thing_that_has_gone_is_gone(laden, bare, sensor):
    """Its frayed outline, too: no voxel of its place stays unseen."""
    frames = with_noise(joined(laden, bare), sensor_noise(sensor))
    dut = a_map(frames)
    np.testing.assert_allclose(distances(dut, BESIDE_THING), truth(), atol=0.03)
    p_W = np.random.default_rng(0).uniform(-1, 1, (2000, 3)) * 0.14
    p_W += [1, 0, 0.65]
    assert (dut.coverage.states_at(p_W) == FREE).all()


def test_a_thing_that_has_come_is_there(map_with_thing):
    np.testing.assert_allclose(
        distances(map_with_thing, BESIDE_THING), truth(THING), atol=0.01
    )


def test_behind_what_has_come_is_what_was_there_before(map_with_thing):
    """The table under the thing, which no newer view can see."""
    under = map_with_thing.splat_W.cropped(
        np.array([0.93, -0.07, 0.42]), np.array([1.07, 0.07, 0.44])
    )
    assert len(under) > 5


def test_a_base_is_brought_up_to_date(bare, laden, bare_map):
    with_thing = a_map(laden, base=bare_map.splat_W)
    np.testing.assert_allclose(
        distances(with_thing, BESIDE_THING), truth(THING), atol=0.01
    )
    cleared = a_map(bare, base=with_thing.splat_W)
    np.testing.assert_allclose(
        distances(cleared, BESIDE_THING), truth(), atol=0.02
    )


def test_a_frame_that_nothing_bears_out_fills_space_and_clears_none(
    laden, solid_map
):
    """It may be elsewhere: it shows what is there, but not what is free."""
    alone = moved(laden, ASIDE)
    both = a_map(joined(laden, alone), unseen_is_solid=True)
    assert "4 frames (1 unconfirmed, not used for free space)" in both.quality
    was_unseen = solid_map.coverage.state == UNSEEN
    now = both.coverage.state[was_unseen]
    assert (now != FREE).all()
    assert (now == SURFACE).sum() > 20
    # Another frame sees the same: then it counts.
    again = a_map(
        joined(laden, alone, moved(alone, NEARLY)), unseen_is_solid=True
    )
    assert again.coverage.fraction(FREE) > solid_map.coverage.fraction(FREE)


def test_nor_does_it_say_that_anything_has_gone(laden, laden_map):
    base = laden_map.splat_W
    two = joined(moved(laden, ASIDE), moved(laden, ACROSS))
    alone = a_map(two, base=base)
    assert "2 unconfirmed" in alone.quality
    assert len(alone.splat_W) >= len(base)


def test_a_single_frame_adds_to_a_splat_and_clears_nothing(
    bare, laden, bare_map, laden_map
):
    one = np.array([0])
    added = a_map(laden.select(one), base=bare_map.splat_W)
    assert "1 frame (1 unconfirmed" in added.quality
    assert np.median(distances(added, BESIDE_THING) - truth(THING)) < 0.01
    base = laden_map.splat_W
    again = a_map(bare.select(one), base=base)
    assert len(again.splat_W) >= len(base)
    assert (distances(again, BESIDE_THING) <= truth(THING) + 0.01).all()


def test_unknown_space_is_an_obstacle_if_so_configured(
    laden, laden_map, solid_map
):
    under_table = Spheres.at([1, 0, 0.2])
    beside = Spheres.at([1, 0.2, 0.6])
    assert distances(laden_map, under_table) > 0.1
    assert distances(solid_map, under_table) < 0
    assert distances(solid_map, beside) > 0.02
    there = a_map(laden, robot_free=under_table, unseen_is_solid=True)
    assert distances(there, under_table) > CONFIG.robot_margin - 1e-9
    assert there.coverage.fraction(FREE) > solid_map.coverage.fraction(FREE)


def test_what_the_base_has_seen_stays_known(bare, bare_map):
    state = bare_map.coverage.state.copy()
    # But for the floor, of which a single view shows a part.
    state[:2, :, 2:] = FREE
    base_seen = dc.replace(bare_map.coverage, state=state)
    dut = a_map(bare, base_seen=base_seen)
    assert (dut.coverage.state[:2, :, 2:] != UNSEEN).all()
    np.testing.assert_array_equal(
        dut.coverage.state[2:], bare_map.coverage.state[2:]
    )


def test_farther_surfaces_are_left_out_but_not_what_is_before_them(
    bare, bare_map
):
    config = MappingConfig(**(vars(CONFIG) | {"max_depth": 1.0}))
    near = a_map(bare, config)
    far = near.splat_W.p_GK[:, None] - bare.X_WC[None, :, :3, 3]
    assert np.linalg.norm(far, axis=2).min(axis=1).max() < 1.4
    assert len(near.splat_W) < len(bare_map.splat_W)


def test_equal_frames_make_equal_maps(laden, laden_map, tmp_path):
    one, two = laden_map, a_map(laden)
    assert one.field.revision == two.field.revision
    write_map(tmp_path / "map.rsmap", one)
    opened = open_map(tmp_path / "map.rsmap")
    np.testing.assert_array_equal(
        distances(opened, BESIDE_THING), distances(two, BESIDE_THING)
    )


def test_frames_that_show_nothing_make_no_map(bare):
    blind = bare.select(np.arange(2))
    blind.depth[:] = 0
    with pytest.raises(RemoSplatError, match="depth"):
        a_map(blind)
    with pytest.raises(RemoSplatError, match="valid: full, quick"):
        a_map(bare, effort="some")
