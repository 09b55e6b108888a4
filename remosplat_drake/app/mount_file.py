"""Writes the wrist camera's mount into the file of a scenario."""

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix

from remosplat_drake.app.scenario import find_scenario, load_scenario
from remosplat_drake.base.atomic_file import replace_checked
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.yaml_edit import with_values
from remosplat_drake.base.yaml_nodes import read_text


def mount_fields(X_FC: np.ndarray) -> dict[str, list[float]]:
    """Returns the fields of `wrist_camera` that describe the camera's pose.

    Args:
        X_FC: The camera's pose in the frame that carries it, shape (4, 4).

    Returns:
        Translation [m], to a hundredth of a millimetre, and roll, pitch and
        yaw [deg].
    """
    R_FC = RotationMatrix.ProjectToRotationMatrix(X_FC[:3, :3])
    angles = np.rad2deg(RollPitchYaw(R_FC).vector())
    return {
        "translation": X_FC[:3, 3].round(5).tolist(),
        "rpy_deg": angles.round(4).tolist(),
    }


def write_mount(spec: str, X_FC: np.ndarray) -> None:
    """Sets the mount in a scenario's file, and keeps all other text.

    Args:
        spec: FILE or FILE:NAME, as on the command line.
        X_FC: The camera's pose in the frame that carries it, shape (4, 4).

    Raises:
        RemoSplatError: The file cannot be read or written, or contains the
            mount in a form that cannot be replaced. The file is then unchanged.
    """
    path, name = find_scenario(spec)
    fields = mount_fields(X_FC)
    before = read_text(path)
    values = {field: str(value) for field, value in fields.items()}
    after = with_values(before, (name, "wrist_camera"), values, path)

    def check() -> None:
        camera = load_scenario(f"{path}:{name}").camera
        if camera is None or any(
            getattr(camera, field) != value for field, value in fields.items()
        ):
            problem = (
                "wrist_camera is written in a form that the program cannot "
                f"edit; set {values} by hand"
            )
            raise FileError(path, problem)

    replace_checked(path, after, check)
