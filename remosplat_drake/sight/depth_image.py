"""`DepthImage`: what a depth camera saw, from where, and when."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import check_camera
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.sight.kernels.depth_lookup import depth_lookup


@dc.dataclass(frozen=True, eq=False)
class DepthImage:
    """One posed depth image; copying returns the object itself.

    Attributes:
        camera: Name of the camera.
        time: When it was taken [s].
        K: Intrinsic matrix, shape (3, 3) [pixels]; see `Capture`.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).
        depth: Depth z in C, shape (h, w), float32 [m]; 0 where it is unknown,
            inf where there is nothing as far as the camera sees.
        near: Least depth at which the camera sees anything [m].
        far: Greatest depth at which it does [m].

    Raises:
        RemoSplatError: The camera or its pose is none, or the time is not
            finite.
    """

    camera: str
    time: float
    K: np.ndarray
    X_WC: np.ndarray
    depth: np.ndarray
    near: float = 0.05
    far: float = 10.0

    def __post_init__(self):
        if not np.isfinite(self.time):
            raise RemoSplatError(f"{self.camera}: its stamp is {self.time}")
        depth = np.asarray(self.depth)
        if depth.ndim != 2 or not depth.size:
            raise RemoSplatError(
                f"{self.camera}: depth of shape {depth.shape} is no image"
            )
        check_camera(self.camera, np.asarray(self.K), np.asarray(self.X_WC))
        for name, kind in (("K", float), ("X_WC", float), ("depth", "f4")):
            value = np.ascontiguousarray(getattr(self, name), kind)
            object.__setattr__(self, name, value)

    def __deepcopy__(self, memo) -> "DepthImage":
        return self

    @property
    def p_WC(self) -> np.ndarray:
        """Position of the camera in W, shape (3,) [m]."""
        return self.X_WC[:3, 3]

    def as_mover_camera(
        self, seen: float, far: float, problem: str
    ) -> MoverCamera:
        """Says which space the camera watches.

        Args:
            seen: When its latest image was taken that could be used [s].
            far: Depth beyond which what it sees is not trusted [m].
            problem: Why there is no newer one; empty where nothing is wrong.
        """
        height, width = self.depth.shape
        focal = np.array([self.K[0, 0], self.K[1, 1]])
        center = self.K[:2, 2]
        return MoverCamera(
            self.camera,
            RigidTransform(
                RotationMatrix.ProjectToRotationMatrix(self.X_WC[:3, :3]),
                self.p_WC,
            ),
            -center / focal,
            (np.array([width, height]) - center) / focal,
            self.near,
            min(self.far, far),
            seen,
            problem,
        )

    def stride(self, columns: int) -> int:
        """Returns the step between pixels of which there are `columns`."""
        return max(1, self.depth.shape[1] // columns)

    def depths_at(self, p_W: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compares points with what is seen in their direction.

        Args:
            p_W: n points in W, shape (n, 3) [m].

        Returns:
            The points in C, shape (n, 3) [m], and how far the camera sees at
            their pixels, shape (n,) [m]; NaN where nothing was measured, or the
            point is outside of the image.
        """
        p_W = np.ascontiguousarray(p_W)
        return depth_lookup(self.depth, self.K, self.X_WC, self.far, p_W)

    def balls(self, spheres: Spheres) -> np.ndarray:
        """Returns spheres as the camera sees them.

        Args:
            spheres: Spheres in W.

        Returns:
            Their centres in C and radii, shape (n, 4) [m].
        """
        p_CS = (spheres.p_WS - self.p_WC) @ self.X_WC[:3, :3]
        return np.column_stack([p_CS, spheres.radius])
