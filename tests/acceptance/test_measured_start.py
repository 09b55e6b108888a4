"""The true place of a robot decides whether it may start."""

import re
import signal
import subprocess
import time

import numpy as np
from patience import PATIENCE
from runs import command_line

from remosplat_drake.acceptance.hardware_processes import end, free_url, robot
from remosplat_drake.acceptance.motion_judge import CREEP, TrueRun

ELSEWHERE = """
TableReach:
  scene:
    splat: package://remosplat_drake/models/scenes/table/splat.ply
    truth: package://remosplat_drake/models/scenes/table/scene.json
  robot: {base_pose: [0.32, -0.186, 0.0]}
"""
"""A finger is 6 mm from the table, where 16 mm are the least."""


REASON = re.compile(r"in the map (\w+) starts at a clearance of ([\d.]+)")


def test_a_robot_that_stands_too_near_in_the_map_does_not_start(wire, tmp_path):
    scenario, motion = tmp_path / "elsewhere.yaml", tmp_path / "motion.npz"
    scenario.write_text(ELSEWHERE)
    url = free_url()
    line = command_line(
        *("run", "TableReach", "--hardware", "--without-doctor", "--headless"),
        *("--lcm-url", url, "--output", tmp_path),
    )
    said, heard = "", tmp_path / "said.txt"
    with (
        robot(url, str(scenario), "--record", str(motion)) as process,
        heard.open("w") as file,
        subprocess.Popen(line, stderr=file) as run,
    ):
        while not (reason := REASON.search(said)) and run.poll() is None:
            time.sleep(0.1)
            said = " ".join(heard.read_text().split())
        # It waits for its operator: one may move the robot.
        run.send_signal(signal.SIGINT)
        assert run.wait(PATIENCE) == 1, said
        end(process)
    assert reason, said
    assert reason[1] == "panda_leftfinger"
    assert 4 < float(reason[2]) < 8
    q = TrueRun.read(motion).q
    assert np.ptp(q, axis=0).max() < CREEP
