"""`Cameras`: a simulated hand-held camera, with lens and rolling shutter."""

import dataclasses as dc

import numpy as np

from apps.studies.true_maps.ray_casting import Hits, RayCaster
from apps.studies.true_maps.walk import Walk
from remosplat_drake.capture.undistortion import Distortion, distort

WIDTH, HEIGHT = 320, 240
"""Size of the images [pixels]."""

FOCAL = WIDTH / 2 / np.tan(np.deg2rad(30))
"""Focal length: 60 degrees from left to right [pixels]."""

FAR = 8.0
"""Largest measured depth [m]."""

_ROUNDS = 12
"""Steps in which a lens is inverted; the error shrinks to a tenth in each."""


@dc.dataclass(frozen=True, eq=False)
class Cameras:
    """n images of one hand-held camera.

    Attributes:
        walk: The camera's path.
        time: Read-out time of each image's middle row, shape (n,) [s].
        K: Intrinsic matrix, shape (3, 3) [pixels].
        lens: Distortion of the lens.
        readout: Time from the first row of an image to the last [s].
    """

    walk: Walk
    time: np.ndarray
    K: np.ndarray
    lens: Distortion = dc.field(default_factory=Distortion)
    readout: float = 0.0

    def __len__(self) -> int:
        return len(self.time)

    @property
    def X_WC(self) -> np.ndarray:
        """Poses at which the middle rows are read, shape (n, 4, 4)."""
        return self.walk.X_WC(self.time)

    def rays(self, view: int) -> tuple[np.ndarray, np.ndarray]:
        """Returns the rays of a view's pixels: their starts and directions.

        Returns:
            Starts in W, shape (h, 1, 3) [m], and directions, shape (h, w, 3),
            of unit depth.
        """
        X_WC = self.poses(view, np.arange(HEIGHT) + 0.5)
        u, v = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
        seen = np.stack([u - self.K[0, 2], v - self.K[1, 2]], axis=-1)
        seen /= [self.K[0, 0], self.K[1, 1]]
        xy = self._undistorted(seen)
        ray_C = np.concatenate([xy, np.ones((HEIGHT, WIDTH, 1))], axis=-1)
        ray_W = ray_C @ X_WC[:, :3, :3].transpose(0, 2, 1)
        return X_WC[:, None, :3, 3], ray_W

    def project(self, view: int, p_W: np.ndarray) -> tuple[np.ndarray, ...]:
        """Projects points to the pixels of a view, ignoring occlusion.

        Args:
            view: Index of the view.
            p_W: The points, shape (n, 3) [m].

        Returns:
            Column, row [pixels, from the image's corner] and depth z [m] of
            each; column and row are NaN behind the camera, and far outside the
            image, where the polynomial of the distortion turns back.
        """
        widest = self._widest()
        row = np.full(len(p_W), HEIGHT / 2)
        # Row and pose depend on each other; the iteration converges at once.
        for _ in range(1 if self.readout == 0 else 4):
            X_WC = self.poses(view, row)
            p_C = np.einsum("nji,nj->ni", X_WC[:, :3, :3], p_W - X_WC[:, :3, 3])
            z = np.where(p_C[:, 2] > 0, p_C[:, 2], np.nan)
            xy = p_C[:, :2] / z[:, None]
            xy[np.linalg.norm(xy, axis=1) > widest] = np.nan
            xy = distort(self.lens, xy)
            u, v = (xy * [self.K[0, 0], self.K[1, 1]] + self.K[:2, 2]).T
            row = np.clip(np.nan_to_num(v, nan=0.0), 0, HEIGHT)
        return u, v, p_C[:, 2]

    def images(self, caster: RayCaster) -> tuple[np.ndarray, ...]:
        """Takes the images: rgb (n, h, w, 3), depth (n, h, w), 0 for none."""
        rgb = np.empty((len(self), HEIGHT, WIDTH, 3), np.uint8)
        depth = np.empty((len(self), HEIGHT, WIDTH), np.float32)
        for view in range(len(self)):
            p_W, ray_W = self.rays(view)
            hits = caster.cast(p_W, ray_W)
            depth[view] = known_depth(hits)
            rgb[view] = caster.colors(
                hits, p_W + ray_W * depth[view][..., None]
            )
        return rgb, depth

    def poses(self, view: int, row: np.ndarray) -> np.ndarray:
        """Returns the poses at which rows (n,) of a view are read, (n, 4, 4).

        Args:
            view: Index of the view.
            row: Positions of the rows, from the image's upper edge [pixels].
        """
        late = self.readout * (row / HEIGHT - 0.5)
        return self.walk.X_WC(self.time[view] + late)

    def _widest(self) -> float:
        """Largest slope of a ray through the image, and a tenth more."""
        corners = np.array([[0, 0], [0, HEIGHT], [WIDTH, 0], [WIDTH, HEIGHT]])
        seen = (corners - self.K[:2, 2]) / [self.K[0, 0], self.K[1, 1]]
        return 1.1 * np.linalg.norm(self._undistorted(seen), axis=1).max()

    def _undistorted(self, seen: np.ndarray) -> np.ndarray:
        """Undistorted points of the image plane."""
        xy = seen
        if self.lens != Distortion():
            for _ in range(_ROUNDS):
                xy = xy + seen - distort(self.lens, xy)
        return xy


def known_depth(hits: Hits) -> np.ndarray:
    """Depths that a camera can measure [m]; 0 for none."""
    return np.where(hits.z < FAR, hits.z, 0)


def pinhole() -> np.ndarray:
    """Returns the true intrinsic matrix of the camera, (3, 3)."""
    return np.array(
        [[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1.0]]
    )
