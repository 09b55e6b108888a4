"""Where the robot truly stands decides whether it may start."""

import re

import numpy as np
from runs import remosplat

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


def test_a_robot_that_stands_too_near_in_the_map_does_not_start(wire, tmp_path):
    scenario, motion = tmp_path / "elsewhere.yaml", tmp_path / "motion.npz"
    scenario.write_text(ELSEWHERE)
    url = free_url()
    with robot(url, str(scenario), "--record", str(motion)) as process:
        result = remosplat(
            *(
                "run",
                "TableReach",
                "--hardware",
                "--without-doctor",
                "--headless",
            ),
            *("--lcm-url", url, "--output", tmp_path),
        )
        end(process)
    assert result.returncode == 1, result.stderr
    said = " ".join(result.stderr.split())
    reason = re.search(
        r"in the map (\w+) starts at a clearance of ([\d.]+)", said
    )
    assert reason, said
    assert reason[1] == "panda_leftfinger"
    assert 4 < float(reason[2]) < 8
    q = TrueRun.read(motion).q
    assert np.ptp(q, axis=0).max() < CREEP
