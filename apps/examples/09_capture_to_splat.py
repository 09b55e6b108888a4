"""From posed RGB-D images to a splat, with its errors.

The images are rendered from a known scene, so the splat's distances can be
compared with the truth. The example needs the extra `reconstruction`.
"""

import numpy as np

import remosplat_drake as rs
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.reconstruction.pipeline import reconstruct

SCENE = "package://remosplat_drake/models/scenes/table/scene.json"


def main() -> None:
    """Renders sixteen views, makes a splat and compares distances."""
    scene = rs.read_scene(SCENE).with_floor()
    capture = render_capture(scene, survey_poses(scene, n=16), 160, 120)
    splat = reconstruct(capture, device="none").splat
    print(f"{len(splat)} discs")

    believed = rs.SphereToEllipsoid().make(splat)
    true = rs.GroundTruth().make(truth=scene)
    robot = rs.load_robot("frankie", floor_height=0.03)
    errors = []
    for x in np.linspace(-0.5, 0.2, 15):
        spheres = robot.spheres_at(robot.q_home + np.eye(robot.n_q)[0] * x)
        believed_at, true_at = (
            field.clearances(spheres).per_sphere(len(spheres))
            for field in (believed, true)
        )
        errors.append(believed_at - true_at)
    print(f"median error {1e3 * np.nanmedian(errors):.1f} mm")
    print(f"largest over-estimate {1e3 * np.nanmax(errors):.1f} mm")


if __name__ == "__main__":
    main()
