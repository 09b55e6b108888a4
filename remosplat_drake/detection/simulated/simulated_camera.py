"""`SimulatedCamera`: renders depth images of solids, robot and movers."""

import copy
import dataclasses as dc

import numpy as np

from remosplat_drake.capture.rendering.sensor_noise import (
    SensorNoise,
    noisy_depth,
)
from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.kernels.ray_cast import ray_cast
from remosplat_drake.detection.simulated.cast_solids import (
    mover_solids,
    scene_solids,
    sphere_solids,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene

NEAREST = 0.05
"""Least depth of a simulated camera, independent of its noise [m]."""


@dc.dataclass(frozen=True, eq=False)
class SimulatedImage:
    """An image of a simulated camera, with its true content.

    Attributes:
        image: The depth image, with its noise.
        pixels: Number of pixels that would show each of the k movers, within
            the camera's range and without noise, shape (k,).
    """

    image: DepthImage
    pixels: np.ndarray


class SimulatedCamera:
    """A simulated depth camera, which casts one ray per pixel.

    An image of 80 x 60 pixels takes a millisecond. The static scene is rendered
    only when the camera's pose changes.

    Args:
        name: Name of the camera.
        K: Intrinsic matrix, shape (3, 3) [pixels].
        size: Height and width [pixels].
        scene: The static scene; None for an empty one.
        noise: Noise model of the camera.
        seed: Seed of the noise. The noise of an image depends on the seed and
            on the number of earlier images.
        far: Largest depth that the camera measures, apart from its noise model
            [m].
    """

    def __init__(
        self,
        name: str,
        K: np.ndarray,
        size: tuple[int, int],
        scene: PrimitiveScene | None,
        noise: SensorNoise | None = None,
        seed: int = 0,
        far: float = 10.0,
    ):
        self.name, self.K, self.size = name, np.array(K, float), size
        self._far = far
        self._noise = noise or SensorNoise()
        self._seed, self._taken = seed, 0
        self._solids = scene_solids(scene or PrimitiveScene())
        self._X_WC = np.full((4, 4), np.nan)
        self._still = np.full(size, np.inf, np.float32)

    def __deepcopy__(self, memo) -> "SimulatedCamera":
        return copy.copy(self)  # Arrays are replaced, never modified.

    def take(
        self,
        X_WC: np.ndarray,
        time: float,
        movers: Movers | None = None,
        spheres: Spheres | None = None,
    ) -> SimulatedImage:
        """Renders an image of the robot, the movers and the static scene.

        Args:
            X_WC: The camera's pose (OpenCV axes), shape (4, 4).
            time: Time of the image [s].
            movers: The movers at that time.
            spheres: The robot at that time.
        """
        X_WC = np.ascontiguousarray(X_WC, float)
        label = np.full(self.size, -1, np.int32)
        if not np.array_equal(X_WC, self._X_WC):
            self._X_WC = X_WC.copy()
            self._still = np.full(self.size, np.inf, np.float32)
            self._draw(X_WC, self._solids, -1, self._still, label.copy())
        depth = self._still.copy()
        k = 0 if movers is None else len(movers)
        if movers is not None and k:
            self._draw(X_WC, mover_solids(movers), 0, depth, label)
        if spheres is not None:
            self._draw(X_WC, sphere_solids(spheres), k, depth, label)
        near, far = self._range
        measured = (depth >= near) & (depth <= far)
        shown = label[(label >= 0) & (label < k) & measured]
        image = DepthImage(
            self.name,
            time,
            self.K,
            X_WC,
            self._with_noise(depth),
            near,
            far,
        )
        return SimulatedImage(image, np.bincount(shown, minlength=k))

    @property
    def _range(self) -> tuple[float, float]:
        """Least and greatest depth that the camera measures [m]."""
        noise = self._noise
        near = max(NEAREST, noise.min_range)
        return near, min(self._far, noise.max_range)

    def _draw(self, X_WC, solids, first, depth, label):
        if len(solids.radius):
            ray_cast(self.K, X_WC, solids, first, NEAREST, depth, label)

    def _with_noise(self, depth: np.ndarray) -> np.ndarray:
        if self._noise == SensorNoise():
            return depth
        nothing = np.isinf(depth) | (depth > self._noise.max_range)
        clean = np.where(np.isinf(depth), np.float32(0), depth)
        self._taken += 1
        rng = np.random.default_rng([self._seed, self._taken])
        noisy = noisy_depth(self.K, clean, self._noise, rng)
        return np.where(nothing, np.float32(np.inf), noisy)
