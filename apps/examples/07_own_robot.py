"""A robot of your own, defined by three small files.

`planar_arm/` contains a URDF, the spheres that cover its links (`remosplat
fit-spheres` makes them from meshes), and a description with the roles and speed
limits of the joints.
"""

from pathlib import Path

import numpy as np

import remosplat_drake as rs
from remosplat_drake.app.target_config import TargetConfig

FILE = Path(__file__).parent / "planar_arm" / "planar_arm.yaml"
SCENE = "package://remosplat_drake/models/scenes/table/scene.json"


def main() -> None:
    """Prints the arm's clearances, and moves it over the table."""
    robot = rs.load_robot(FILE)
    truth = rs.GroundTruth().make(truth=rs.read_scene(SCENE))
    for elbow in (-2.0, -1.0, 0.0):
        spheres = robot.spheres_at(np.array([1.2, elbow]))
        clearance = truth.clearances(spheres).minimum()
        print(f"elbow at {elbow:4.1f} rad: {1e3 * clearance:6.1f} mm")

    scenario = rs.load_scenario("TableGroundTruth")
    scenario.robot.model = str(FILE)
    scenario.robot.base_pose = None
    X_WE = robot.end_effector_pose(np.array([0.9, -1.2]))
    scenario.targets = [
        TargetConfig(
            translation=X_WE[:3, 3].tolist(), rotation=X_WE[:3, :3].tolist()
        )
    ]
    result = rs.run(rs.build(scenario))
    print(f"{result.outcome}, {1e3 * result.position_error:.1f} mm off")


if __name__ == "__main__":
    main()
