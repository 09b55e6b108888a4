"""Things before cameras: found, followed, enclosed, and gone when they are."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from room import (
    CONFIG,
    FRAME,
    LEFT,
    NO_ROBOT,
    RIGHT,
    ROOM,
    K,
    Watch,
    ball,
    camera,
    known_room,
    looking,
)

from remosplat_drake.detection.detection_state import DetectionState, add_image
from remosplat_drake.detection.enclosure import RoundedBox
from remosplat_drake.detection.kernels.scan import UNASKED
from remosplat_drake.detection.known_scene import KnownScene, surface_points
from remosplat_drake.detection.simulated.camera_detection import coarse_noise
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.mover_contacts import distances
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box


def outside(movers, p_W, radius) -> float:
    """How far a ball sticks out of what is known of it [m]."""
    directions = np.random.default_rng(0).normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    surface = p_W + radius * directions
    apart = [
        RoundedBox(
            m.X_WM.rotation().matrix(),
            m.X_WM.translation(),
            m.half_extents,
            m.radius + m.position_error,
        ).distance(surface)
        for m in movers
    ]
    return float(np.min(apart, axis=0).max())


@pytest.mark.parametrize("poses", [[LEFT], [LEFT, RIGHT]])
def test_a_ball_that_crosses_is_found_enclosed_and_followed(poses):
    watch = Watch(poses)
    v_W = np.array([0.0, 0.8, 0.0])
    names = set()
    for i in range(45):
        time = i * FRAME / len(poses)
        p_W = np.array([0.3, -0.6, 0.9]) + time * v_W
        _, movers = watch.see(time, ball(p_W, v_W), i % len(poses))
        if i < 1:
            continue
        assert len(movers), "found within two images"
        assert movers.stamp == time
        assert outside(movers, p_W, 0.12) <= 0.0
        for mover in movers:
            off = np.linalg.norm(mover.v_WM - v_W)
            assert off <= mover.velocity_error
            names.add(mover.name.split(".")[0])
    assert names == {"seen 1"}
    assert max(m.velocity_error for m in movers) < 1.2
    assert np.linalg.norm(movers.movers[0].v_WM - v_W) < 0.4


def test_what_has_gone_leaves_no_ghost():
    watch = Watch([LEFT, RIGHT])
    for i in range(20):
        _, movers = watch.see(i * FRAME / 2, ball([0.3, 0, 0.9]), i % 2)
    assert len(movers)
    for i in range(20, 38):
        _, movers = watch.see(i * FRAME / 2, None, i % 2)
    assert not len(movers), "0.3 s later"


def test_noise_alone_is_nothing():
    watch = Watch([LEFT, RIGHT])
    half, noise = np.diag([0.5, 0.5, 1.0]) @ K, coarse_noise(40 / 640)
    watch.cameras = [
        SimulatedCamera(str(i), half, (30, 40), ROOM, noise, i) for i in (0, 1)
    ]
    for i in range(1000):
        _, movers = watch.see(i * FRAME / 2, None, i % 2)
        assert not len(movers)


def test_a_newcomer_is_handed_to_the_map_without_a_gap():
    """It stays in the layer until a version of the map has it."""
    watch = Watch([LEFT])
    box = Box(RigidTransform([0.9, -0.2, 0.7]), np.full(3, 0.1))
    later = dc.replace(ROOM, boxes=(*ROOM.boxes, box))
    watch.cameras = [camera("0", scene=later)]
    for i in range(60):
        _, movers = watch.see(i * FRAME)
        assert i < 2 or len(movers)
    settled = watch.detection.settled(CONFIG)
    assert [track.name for track in settled] == ["seen 1"]
    assert np.linalg.norm(movers.movers[0].v_WM) < 0.1
    watch.known = KnownScene(
        SignedDistanceField(later), CONFIG, surface_points(None, later)
    )
    _, movers = watch.see(60 * FRAME)
    assert not len(movers)


def test_the_robot_is_no_mover_wherever_it_moves():
    watch = Watch([LEFT, RIGHT])
    for i in range(60):
        at = [0.2 + 0.3 * np.sin(0.2 * i), 0.3 * np.cos(0.2 * i), 0.8]
        arm = np.linspace([0, 0, 0.1], at, 12)
        watch.spheres = Spheres.at(arm, 0.08)
        shot, movers = watch.see(i * FRAME / 2, None, i % 2)
        assert not len(movers)
    assert (shot.image.depth < 1.9).sum() > 100, "it is in view"


def test_a_camera_that_moves_sees_a_ball_and_nothing_else():
    watch = Watch([LEFT])
    v_W = np.array([0.5, 0.0, 0.0])
    for i in range(30):
        time = i * FRAME
        turn = 0.4 * np.sin(3 * time)
        p_WC = [-0.4, -0.5 + 0.3 * time, 1.2 + 0.1 * turn]
        watch.poses = [looking(p_WC, [0.6, turn, 0.6])]
        p_W = np.array([0.2, 0.0, 0.9]) + time * v_W
        moving = ball(p_W, v_W, 0.1) if i >= 10 else None
        _, movers = watch.see(time, moving)
        if i < 10:
            assert not len(movers)
        if i >= 11:
            assert len(movers)
            assert all(
                np.linalg.norm(m.v_WM - v_W) <= m.velocity_error for m in movers
            )
            assert outside(movers, p_W, 0.1) <= 0.0


def test_what_the_robot_hides_is_remembered_and_grows():
    """A ball stops behind the arm: it is not gone, and may be anywhere near."""
    watch = Watch([LEFT])
    still = ball([0.4, 0.0, 0.9], radius=0.1)
    for i in range(10):
        watch.see(i * FRAME, still)
    between = 0.5 * (LEFT[:3, 3] + [0.4, 0.0, 0.9])
    watch.spheres = Spheres.at(between[None], 0.25)
    reach = []
    for i in range(10, 20):
        shot, movers = watch.see(i * FRAME, still)
        assert not shot.pixels.any()
        assert len(movers)
        assert outside(movers, np.array([0.4, 0.0, 0.9]), 0.1) <= 0.0
        reach.append(max(m.position_error for m in movers))
    assert np.all(np.diff(reach) > 0)
    watch.spheres = NO_ROBOT
    for i in range(20, 23):
        _, movers = watch.see(i * FRAME)
    assert not len(movers), "seen to be free"


def test_who_touches_the_robot_is_there_although_no_image_tells():
    """What is as near to the robot as the robot's margin is the robot."""
    watch = Watch([LEFT, RIGHT])
    watch.spheres = Spheres.at(np.array([[0.3, 0.0, 1.0]]), 0.15)
    v_W, touching = np.array([0.0, -0.6, 0.0]), np.array([0.3, 0.15, 1.0])
    arrival = 0.8
    for i in range(150):
        time = 0.5 * FRAME * i
        left = max(arrival - time, 0.0)
        at = ball(touching - left * v_W, v_W if left else np.zeros(3), 0.08)
        _, movers = watch.see(time, at, i % 2)
        if 0 < time - arrival < CONFIG.memory - 0.2:
            assert len(movers), "what was seen there before has not gone"


def forearm(tip_W, v_W=(0.0, 0.0, 0.0), length=0.4, radius=0.05) -> Movers:
    """A capsule along y whose end of lesser y is at a place."""
    middle = np.add(tip_W, [0.0, radius + 0.5 * length, 0.0])
    X_WM = RigidTransform(RotationMatrix.MakeXRotation(np.pi / 2), middle)
    size = np.array([0.0, 0.0, 0.5 * length])
    v_WM = np.array(v_W, float)
    return Movers(0.0, [Mover("arm", X_WM, size, radius, v_WM=v_WM)])


def test_a_hand_on_the_robot_stays_there_as_long_as_the_arm_is_seen():
    """No image tells the hand from the robot, for longer than the memory."""
    watch = Watch([LEFT, RIGHT])
    robot = np.array([0.3, 0.0, 1.0])
    watch.spheres = Spheres.at(robot[None], 0.15)
    v_W, tip_W = np.array([0.0, -0.5, 0.0]), np.array([0.3, 0.15, 1.0])
    arrival = 1.0
    for i in range(300):
        time = 0.5 * FRAME * i
        left = max(arrival - time, 0.0)
        at = forearm(tip_W - left * v_W, v_W if left else np.zeros(3))
        _, movers = watch.see(time, at, i % 2)
        if time > arrival:
            known = movers.at(movers.stamp)
            apart, _ = distances(known, robot[None], np.array([0.15]))
            assert apart.min() <= 0.0
    assert movers.stamp - arrival > 1.5 * CONFIG.memory


def test_a_thing_a_little_beside_the_robot_is_seen():
    """Only its depth is as uncertain as that it may be the robot's."""
    watch = Watch([LEFT])
    right, ahead = LEFT[:3, 0], LEFT[:3, 2]
    robot = LEFT[:3, 3] + 1.6 * ahead
    watch.spheres = Spheres.at(robot[None], 0.15)
    gap = 0.06
    assert gap < CONFIG.beside(CONFIG.margin(1.6))
    still = ball(robot + (0.15 + gap + 0.06) * right, radius=0.06)
    for i in range(10):
        _, movers = watch.see(i * FRAME, still)
        assert i < 2 or len(movers)


def test_what_is_seen_beside_the_robot_may_be_the_robot_or_a_thing():
    watch = Watch([LEFT])
    right, ahead = LEFT[:3, 0], LEFT[:3, 2]
    watch.spheres = Spheres.at((LEFT[:3, 3] + ahead)[None], 0.2)
    watch.see(0.0)
    view, place = watch.detection.views["0"], np.zeros((2, 3))
    place[0] = LEFT[:3, 3] + 1.5 * (ahead + 0.22 * right)
    place[1] = LEFT[:3, 3] + 1.5 * (ahead + 0.35 * right)
    p_C, _ = view.image.depths_at(place)
    for behind, told in [(0.0, [False, True]), (0.5, [True, True])]:
        depth = np.full_like(view.image.depth, p_C[0, 2] + behind)
        image = dc.replace(view.image, depth=depth)
        seen = dc.replace(view, image=image)
        assert seen.observes(place, watch.spheres, CONFIG).tolist() == told


def test_memory_has_an_end():
    watch = Watch([LEFT], config=dc.replace(CONFIG, memory=0.3))
    still = ball([0.4, 0.0, 0.9], radius=0.1)
    for i in range(5):
        watch.see(i * FRAME, still)
    between = 0.5 * (LEFT[:3, 3] + [0.4, 0.0, 0.9])
    watch.spheres = Spheres.at(between[None], 0.25)
    for i in range(5, 16):
        _, movers = watch.see(i * FRAME, still)
    assert not len(movers)


def test_a_second_camera_tells_how_deep_a_thing_is():
    one, two = Watch([LEFT]), Watch([LEFT, RIGHT])
    for i in range(10):
        moving = ball([0.3, 0.0, 0.9], radius=0.08)
        one.see(i * FRAME, moving)
        two.see(i * FRAME, moving)
        _, both = two.see((i + 0.5) * FRAME, moving, 1)

    def depth(watch) -> float:
        shown = watch.detection.tracks[0].shown
        return float(np.linalg.norm(shown.back_W - shown.face_W, axis=1).mean())

    assert depth(one) == pytest.approx(CONFIG.thickness)
    assert depth(two) < 0.8 * CONFIG.thickness
    assert outside(both, np.array([0.3, 0, 0.9]), 0.08) <= 0.0


def test_two_balls_are_two_things():
    watch = Watch([LEFT, RIGHT])
    for i in range(20):
        time = i * FRAME / 2
        a = ball([0.3, -0.5 + 0.6 * time, 0.9], [0, 0.6, 0])
        b = ball([0.3, 0.5 - 0.6 * time, 0.9], [0, -0.6, 0])
        both = dc.replace(a, movers=(*a.movers, *b.movers))
        _, movers = watch.see(time, both, i % 2)
    speeds = {m.name.split(".")[0]: m.v_WM[1] for m in movers}
    assert len(speeds) == 2
    assert min(speeds.values()) < -0.2
    assert max(speeds.values()) > 0.2


def test_what_comes_off_a_thing_counts_at_once():
    watch = Watch([LEFT])
    for i in range(30):
        y = 0.02 * max(i - 6, 0)
        pair = [
            Mover.sphere("stays", [0.3, -0.06, 0.9], 0.07),
            Mover.sphere("goes", [0.3, 0.06 + y, 0.9], 0.07),
        ]
        before = watch.detection.tracks
        watch.see(i * FRAME, Movers(i * FRAME, pair))
        if len(watch.detection.tracks) > 1 == len(before):
            assert min(len(t.shown) for t in watch.detection.tracks) < 40
            assert all(t.is_trusted for t in watch.detection.tracks)
            break
    else:
        raise AssertionError("they have never come apart")


def test_an_image_that_contradicts_its_pose_tells_nothing_else():
    watch = Watch([LEFT])
    watch.see(0.0)
    wrong = LEFT.copy()
    wrong[:3, 3] += [0.0, 0.5, -0.4]
    shot = watch.cameras[0].take(LEFT, FRAME)
    misplaced = dc.replace(shot.image, X_WC=wrong)
    after = add_image(watch.detection, misplaced, NO_ROBOT, watch.known, CONFIG)
    view = after.views["0"]
    assert "measures free space behind" in view.problem
    assert view.seen == 0.0, "known until then, and no longer"
    (told,) = after.movers(CONFIG).cameras
    assert told.seen == 0.0
    assert told.problem == view.problem
    watch.see(2 * FRAME)
    assert not watch.detection.views["0"].problem


def test_a_camera_that_was_never_right_has_seen_nothing():
    known = known_room()
    wrong = LEFT.copy()
    wrong[:3, 3] += [0.0, 0.5, -0.4]
    image = dc.replace(camera().take(LEFT, 5.0).image, X_WC=wrong)
    detection = add_image(DetectionState(), image, NO_ROBOT, known, CONFIG)
    (told,) = detection.movers(CONFIG).cameras
    assert told.problem
    assert told.seen == 0.0


def test_a_camera_that_falls_silent_is_told_of():
    watch = Watch([LEFT, RIGHT])
    watch.see(0.0, which=1)
    for i in range(12):
        _, movers = watch.see(i * FRAME)
    first, second = sorted(movers.cameras, key=lambda camera: camera.name)
    assert first.seen == movers.stamp
    assert not first.problem
    assert second.seen == 0.0
    assert second.problem == "no image for 0.4 s"


def test_what_a_camera_watches_is_what_it_sees():
    watch = Watch([LEFT])
    shot, movers = watch.see(0.0)
    (told,) = movers.cameras
    p_W = np.random.default_rng(0).uniform(-2, 2, (500, 3))
    p_C, measured = shot.image.depths_at(p_W)
    z = p_C[:, 2]
    framed = told.frames(p_W)
    assert framed.sum() > 20
    assert not framed[np.isnan(z) | (z < told.near) | (z > told.far)].any()
    assert framed[~np.isnan(measured) & (z > 0.3) & (z < 2.9)].all()


def test_a_person_close_before_the_camera_is_no_contradiction():
    watch = Watch([LEFT])
    ahead = LEFT[:3, 3] + 0.7 * LEFT[:3, 2]
    for i in range(3):
        _, movers = watch.see(i * FRAME, ball(ahead, radius=0.4))
    assert not watch.detection.views["0"].problem
    assert len(movers)


def test_an_image_from_before_is_left_out():
    watch = Watch([LEFT])
    watch.see(1.0)
    before = watch.detection
    watch.see(0.5, ball([0.3, 0, 0.9]))
    assert watch.detection is before


def test_the_map_is_asked_once_for_each_place():
    known = known_room()
    watch = Watch([LEFT], known)
    asked = []
    for i in range(60):
        watch.see(i * FRAME)
        asked.append(int((known.nodes != UNASKED).sum()))
    assert asked[-1] - asked[30] < 0.2 * asked[30]
