"""`Capture`: posed RGB-D images, independent of their file format."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import RemoSplatError

_ROTATION_TOLERANCE = 1e-3
"""A rotation matrix may have rounding errors up to this value, since files
contain only few digits.
"""

_LARGEST = 1e9
"""Largest valid entry of K [pixels] or of a pose [m]. The square of this number
does not overflow.
"""

_MOTIONS = ("velocity_W", "acceleration_W")
"""Fields of `Capture` that describe the motion of its cameras."""

MIN_VIEWS = 2
"""A reconstruction needs at least this many views, unless its caller requires
more."""

MIN_DEPTH_FRACTION = 0.01
"""A reconstruction needs a depth at this fraction of a capture's pixels or
more."""


@dc.dataclass(frozen=True, eq=False)
class Capture:
    """Posed RGB-D images of one size from pinhole cameras C in a frame W.

    There are n images, also called views or frames.

    Attributes:
        K: Intrinsic matrices, shape (n, 3, 3) [pixels]; pixel (row i, column
            j) has its centre at (j + 0.5, i + 0.5).
        X_WC: Camera poses in OpenCV axes (x right, y down, z forward), shape
            (n, 4, 4).
        rgb: sRGB colours, shape (n, h, w, 3), uint8.
        depth: Depth z in C, shape (n, h, w), float32 [m]; 0 where unknown.
        hidden: Pixels that do not show the scene (such as the robot), shape (n,
            h, w), bool; their depth is 0. None: every pixel shows the scene.
        names: Names of the n views in their files; empty if unknown.
        notes: Notes of the reader on doubtful or omitted data, one sentence
            each.
        up_W: Unit vector opposite to gravity; None if the files do not define
            it.
        velocity_W: Angular velocity of each camera [rad/s], then the velocity
            of its centre [m/s], in W, while its image was taken, shape (n, 6);
            None: unknown.
        acceleration_W: Time derivative of `velocity_W`, shape (n, 6) [rad/s^2,
            m/s^2]; None: unknown.

    Raises:
        RemoSplatError: The arrays do not match, or a view's pose is not a rigid
            transform; the error names the view.
    """

    K: np.ndarray
    X_WC: np.ndarray
    rgb: np.ndarray
    depth: np.ndarray
    hidden: np.ndarray | None = None
    names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    up_W: tuple[float, ...] | None = None
    velocity_W: np.ndarray | None = None
    acceleration_W: np.ndarray | None = None

    def __post_init__(self):
        n, height, width = self.depth.shape
        expected = {
            "K": (n, 3, 3),
            "X_WC": (n, 4, 4),
            "rgb": (n, height, width, 3),
        }
        if self.hidden is not None:
            expected["hidden"] = (n, height, width)
            object.__setattr__(
                self, "depth", np.where(self.hidden, 0, self.depth)
            )
        for name in _MOTIONS:
            if getattr(self, name) is not None:
                expected[name] = (n, 6)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise RemoSplatError(
                    f"{name} has shape {getattr(self, name).shape};"
                    f" expected {shape}"
                )
        if self.names and len(self.names) != n:
            raise RemoSplatError(f"{len(self.names)} names for {n} views")
        for view in range(n):
            check_camera(f"view {view}", self.K[view], self.X_WC[view])
        wrong = ~(np.isfinite(self.depth) & (self.depth >= 0))
        if wrong.any():
            view = int(np.argwhere(wrong)[0, 0])
            raise RemoSplatError(
                f"view {view}: depth must be finite and not negative"
            )

    def __len__(self) -> int:
        return len(self.X_WC)

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the images [pixels]."""
        return self.depth.shape[1], self.depth.shape[2]

    def points_W(self, view: int) -> np.ndarray:
        """Back-projects the pixels of a view to scene points in W.

        Args:
            view: Index of the view.

        Returns:
            Shape (h, w, 3) [m]; NaN where the depth is unknown.
        """
        return back_project(self.K[view], self.depth[view], self.X_WC[view])

    def select(self, views: np.ndarray) -> "Capture":
        """Returns the views that a boolean mask or index array selects."""
        hidden = None if self.hidden is None else self.hidden[views]
        names = np.array(self.names, object)[views] if self.names else ()
        return dc.replace(
            self,
            K=self.K[views],
            X_WC=self.X_WC[views],
            rgb=self.rgb[views],
            depth=self.depth[views],
            hidden=hidden,
            names=tuple(names),
            **{
                name: motion[views]
                for name in _MOTIONS
                if (motion := getattr(self, name)) is not None
            },
        )

    def expressed_in(self, X_FW: np.ndarray) -> "Capture":
        """Expresses the capture in a frame F, by the pose of W in F, (4, 4)."""
        R_FW = X_FW[:3, :3]
        up_F = self.up_W and tuple((R_FW @ self.up_W).tolist())
        motions = {
            name: (motion.reshape(-1, 2, 3) @ R_FW.T).reshape(-1, 6)
            for name in _MOTIONS
            if (motion := getattr(self, name)) is not None
        }
        return dc.replace(self, X_WC=X_FW @ self.X_WC, up_W=up_F, **motions)

    def with_depth(
        self, scale: float, offset: float, growth: float = 0.0
    ) -> "Capture":
        """Returns a copy with depths scale * z + offset + growth * z^2 [m]."""
        z = self.depth.astype(float)
        other = scale * z + offset + growth * z * z
        depth = np.where(z > 0, np.maximum(other, 0), 0)
        return dc.replace(self, depth=depth.astype(np.float32))


def back_project(
    K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray
) -> np.ndarray:
    """Back-projects a depth image to scene points in W.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).

    Returns:
        Shape (h, w, 3) [m]; NaN where the depth is 0.
    """
    height, width = depth.shape
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    z = np.where(depth > 0, depth, np.nan).astype(float)
    p_C = np.stack(
        [(u - K[0, 2]) / K[0, 0] * z, (v - K[1, 2]) / K[1, 1] * z, z], axis=-1
    )
    return p_C @ X_WC[:3, :3].T + X_WC[:3, 3]


def check_reconstructible(capture: Capture, least_views: int = MIN_VIEWS):
    """Checks that a capture has enough views and depth for a reconstruction.

    Args:
        capture: The capture.
        least_views: Least number of views.

    Raises:
        RemoSplatError: There are too few views, or too little depth.
    """
    if len(capture) < least_views:
        raise RemoSplatError(
            f"the capture has {len(capture)} view; a reconstruction needs at"
            f" least {least_views}"
        )
    known = (capture.depth > 0).mean()
    if known < MIN_DEPTH_FRACTION:
        raise RemoSplatError(
            f"only {100 * known:.1f} % of the capture's pixels have a depth, "
            "too few for a reconstruction"
        )


def check_camera(name: str, K: np.ndarray, X_WC: np.ndarray):
    """Checks that a view has a pinhole camera and a rigid pose.

    Args:
        name: Name of the view, which the error contains.
        K: Intrinsic matrix, shape (3, 3) [pixels].
        X_WC: Camera pose, shape (4, 4).

    Raises:
        RemoSplatError: The matrix is not an intrinsic matrix, or the pose is
            not a rigid transform.
    """
    if not (np.isfinite(K).all() and np.isfinite(X_WC).all()):
        raise RemoSplatError(f"{name}: its camera or pose is not finite")
    if max(np.abs(K).max(), np.abs(X_WC).max()) > _LARGEST:
        raise RemoSplatError(f"{name}: its camera has numbers above 1e9")
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        raise RemoSplatError(f"{name}: focal lengths must be positive")
    if np.abs(X_WC[3] - [0, 0, 0, 1]).max() > _ROTATION_TOLERANCE:
        raise RemoSplatError(
            f"{name}: the last row of its pose must be 0 0 0 1; is the pose "
            "transposed?"
        )
    R_WC = X_WC[:3, :3]
    scale = np.cbrt(np.linalg.det(R_WC))
    if scale < 0:
        raise RemoSplatError(f"{name}: its pose is a reflection, no rotation")
    if abs(scale - 1) > _ROTATION_TOLERANCE:
        raise RemoSplatError(
            f"{name}: its pose is scaled by {scale:.4g};"
            " only metric captures can be used"
        )
    if np.abs(R_WC @ R_WC.T - np.eye(3)).max() > 10 * _ROTATION_TOLERANCE:
        raise RemoSplatError(f"{name}: its pose has no valid rotation")
