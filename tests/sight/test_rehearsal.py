"""Rehearsing: no image waits for a compiler."""

import subprocess
import sys
from pathlib import Path

# Prints how often numba is at work while somebody is seen to pass the robot.
IN_LOOKS = """
import dataclasses as dc
import sys
sys.path.insert(0, sys.argv[1])
from numba.core import event
from room import CONFIG, LEFT, RIGHT, Watch, ball, known_room
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.sight.rehearsal import rehearse
from remosplat_drake.sight.sight import Sight, look

class Count(event.Listener):
    total = 0
    def on_start(self, event):
        self.total += 1
    def on_end(self, event):
        pass

robot, config = load_robot("frankie"), dc.replace(CONFIG, unseen_speed=1.0)
known = known_room(config)
rehearse(robot, known, config)
spheres = robot.spheres_at(robot.home)
watch = Watch([LEFT, RIGHT], known, config, spheres)
shots = []
goal = spheres.p_WS[spheres.p_WS[:, 2].argmax()]
for i in range(60):
    movers = ball(goal + [0.0, 0.0, 0.9 - 0.015 * i], time=i / 30)
    shots.append(watch.cameras[i % 2].take(
        watch.poses[i % 2], i / 30, movers, spheres))
count = Count()
event.register("numba:compiler_lock", count)
sight, seen = Sight(), 0
for shot in shots:
    spheres = robot.spheres_at(robot.home)
    sight = look(sight, shot.image, spheres, known, config)
    sight.movers(config)
    seen = max(seen, len(sight.tracks))
assert seen
print(count.total)
"""


def test_no_look_loads_a_kernel_after_a_rehearsal():
    room = str(Path(__file__).parent)
    result = subprocess.run(
        [sys.executable, "-c", IN_LOOKS, room],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert int(result.stdout) == 0
