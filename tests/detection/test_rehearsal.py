"""Rehearsing: no image waits for a compiler."""

from numba_work import printed_number

# Prints how often numba is at work while a person is seen to pass the robot.
IN_IMAGES = """
import dataclasses as dc
from numba_work import NumbaWork
from room import CONFIG, LEFT, RIGHT, Watch, ball, known_room
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.detection.rehearsal import rehearse
from remosplat_drake.detection.detection_state import DetectionState, add_image

robot, config = load_robot("frankie"), dc.replace(CONFIG, unseen_speed=1.0)
known = known_room(config)
rehearse(robot, known, config)
spheres = robot.spheres_at(robot.q_home)
watch = Watch([LEFT, RIGHT], known, config, spheres)
shots = []
goal = spheres.p_WS[spheres.p_WS[:, 2].argmax()]
for i in range(60):
    movers = ball(goal + [0.0, 0.0, 0.9 - 0.015 * i], time=i / 30)
    shots.append(watch.cameras[i % 2].take(
        watch.poses[i % 2], i / 30, movers, spheres))
work = NumbaWork()
detection, seen = DetectionState(), 0
for shot in shots:
    spheres = robot.spheres_at(robot.q_home)
    detection = add_image(detection, shot.image, spheres, known, config)
    detection.movers(config)
    seen = max(seen, len(detection.tracks))
assert seen
print(work.total)
"""


def test_no_image_loads_a_kernel_after_a_rehearsal():
    assert printed_number(IN_IMAGES) == 0
