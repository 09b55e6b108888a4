"""`DepthImage`: a depth image with its camera pose and time."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import check_camera
from remosplat_drake.detection.kernels.depth_lookup import depth_lookup
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover_camera import MoverCamera


@dc.dataclass(frozen=True, eq=False)
class DepthImage:
    """A depth image with its camera pose and time; a copy is the object itself.

    Attributes:
        camera: Name of the camera.
        time: Time at which the image was taken [s].
        K: Intrinsic matrix, shape (3, 3) [pixels]; see `Capture`.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).
        depth: Depth z in C, shape (h, w), float32 [m]; 0 where it is unknown,
            inf where nothing is within the camera's range.
        near: Least depth of the camera's range [m].
        far: Greatest depth of the camera's range [m].

    Raises:
        RemoSplatError: The camera or its pose is invalid, or the time is not
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
            raise RemoSplatError(
                f"{self.camera}: the image's time must be finite,"
                f" got {self.time}"
            )
        depth = np.asarray(self.depth)
        if depth.ndim != 2 or not depth.size:
            raise RemoSplatError(
                f"{self.camera}: depth of shape {depth.shape} is not an image"
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
        """Returns the space that the camera observes, as a `MoverCamera`.

        Args:
            seen: Time of the camera's latest usable image [s].
            far: Measured depths beyond this one are ignored [m].
            problem: Reason why there is no newer image; empty if there is no
                problem.
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
        """Returns the step that leaves about `columns` pixels per row."""
        return max(1, self.depth.shape[1] // columns)

    def depths_at(self, p_W: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the measured depths in the direction of points.

        Args:
            p_W: n points in W, shape (n, 3) [m].

        Returns:
            The points in C, shape (n, 3) [m], and the measured depths at their
            pixels, up to `far`, shape (n,) [m]. A depth is NaN if nothing was
            measured, or if the point is outside the image.
        """
        p_W = np.ascontiguousarray(p_W)
        return depth_lookup(self.depth, self.K, self.X_WC, self.far, p_W)

    def balls(self, spheres: Spheres) -> np.ndarray:
        """Transforms spheres into the camera's frame.

        Args:
            spheres: Spheres in W.

        Returns:
            The spheres' centres in C and radii, shape (n, 4) [m].
        """
        p_CS = (spheres.p_WS - self.p_WC) @ self.X_WC[:3, :3]
        return np.column_stack([p_CS, spheres.radius])
