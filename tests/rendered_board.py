"""A ChArUco board, rendered with nothing but boxes."""

from itertools import groupby

import numpy as np
from pydrake.geometry import Box, LightParameter, RenderEngineVtkParams
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.camera.board_calibration import CharucoBoard
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.renderer import SceneRenderer
from remosplat_drake.capture.rendering.solids import Solid, painted

BOARD = CharucoBoard(6, 5, 0.04, 0.03)
CELLS = 8
"""Cells along a square; a marker of 4 x 4 bits has 6."""
X_WK = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0.9, 0.1, 0.4])


def transform(rotation_deg, translation) -> np.ndarray:
    X = np.eye(4)
    X[:3, :3] = Rotation.from_euler("xyz", rotation_deg, True).as_matrix()
    X[:3, 3] = translation
    return X


TRUTH = transform([5, -20, 70], [0.05, -0.02, 0.1])


def board_solids() -> list[Solid]:
    """The board as thin black boxes on a white one."""
    size = BOARD.columns * CELLS, BOARD.rows * CELLS
    cells = BOARD.opencv().generateImage(size, marginSize=0, borderBits=1)
    cell, width, height = BOARD.square / CELLS, *size
    solids = []

    def add(u, v, length, thickness, shade, below):
        p_KB = [(u + length / 2) * cell, (v + thickness / 2) * cell, below]
        box = Box(length * cell, thickness * cell, 1e-4)
        look = painted([shade, shade, shade, 1])
        solids.append(Solid(X_WK @ RigidTransform(p_KB), box, look))

    add(-4, -4, width + 8, height + 8, 1.0, 1.5e-4)
    for v, row in enumerate(cells):
        u = 0
        for is_black, run in groupby(row < 128):
            length = len(list(run))
            if is_black:
                add(u, v, length, 1, 0.05, 5e-5)
            u += length
    return solids


def board_capture() -> Capture:
    """Twelve images of the board from all around, at their true poses."""
    light = RenderEngineVtkParams(
        lights=[LightParameter(frame="camera", direction=[0, 0, 1])],
        default_clear_color=[0.4, 0.4, 0.4],
    )
    renderer = SceneRenderer(
        board_solids(), 640, 480, np.deg2rad(45), light=light
    )
    middle = X_WK @ np.array([0.12, 0.1, 0.0])
    rng = np.random.default_rng(1)
    poses = []
    for i in range(12):
        p_WC = middle + rng.uniform((-0.2, -0.2, 0.3), (0.2, 0.2, 0.45))
        roll = RotationMatrix.MakeZRotation(np.deg2rad(-60 + 10 * i))
        poses.append(
            look_at(p_WC, middle + rng.uniform(-0.03, 0.03, 3))
            @ RigidTransform(roll, [0, 0, 0])
        )
    X_WC = np.array([pose.GetAsMatrix4() for pose in poses])
    return Capture(
        K=np.tile(renderer.K, (len(poses), 1, 1)),
        X_WC=X_WC,
        rgb=np.array([renderer.color(pose) for pose in poses]),
        depth=np.array([renderer.depth(pose) for pose in poses]),
    )
