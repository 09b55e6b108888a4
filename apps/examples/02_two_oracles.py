"""Three oracles for the same distance, and their results.

The first oracle computes the exact distance to the splats' ellipsoids. The
second one renders depth views and takes opacity into account, so it ignores
floaters. Known geometry is the reference for both.
"""

import numpy as np

import remosplat_drake as rs

TABLE = "package://remosplat_drake/models/scenes/table"


def main() -> None:
    """Moves the hand over the table, and prints the three clearances."""
    robot = rs.load_robot("frankie", floor_height=0.03)
    splat = rs.read_splat(f"{TABLE}/splat.ply")
    truth = rs.read_scene(f"{TABLE}/scene.json")
    fields = {
        "ellipsoids": rs.SphereToEllipsoid().make(splat),
        "depth views": rs.DepthRasterization().make(splat),
        "truth": rs.GroundTruth().make(truth=truth),
    }
    print(" x [m]", *(f"{name:>12}" for name in fields))
    for x in np.linspace(-0.3, 0.3, 4):
        q = robot.q_home + np.eye(robot.n_q)[0] * x
        spheres = robot.spheres_at(q)
        row = [field.clearances(spheres).minimum() for field in fields.values()]
        print(f"{x:6.2f}", *(f"{1e3 * d:9.1f} mm" for d in row))


if __name__ == "__main__":
    main()
