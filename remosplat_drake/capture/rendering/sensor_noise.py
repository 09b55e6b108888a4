"""`SensorNoise`: a noise model of real RGB-D cameras.

Depth noise grows with the square of the distance, as for triangulation. Depth
is rounded to steps of disparity, outlines are shifted and frayed, and surfaces
at a grazing angle have no depth. The formula is that of Nguyen, Izadi and
Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
tracking" (3DIMPVT 2012).
"""

import dataclasses as dc

import numpy as np
from scipy.ndimage import maximum_filter
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.capture.capture import Capture, back_project

_OUTLINE_JUMP = 0.02
"""Two neighbouring pixels are at an outline if their depths differ by more than
this fraction, unless the pixels are on a steep plane.
"""

_OUTLINE_REACH = 2
"""Pixels within this distance of an outline are disturbed [pixels]."""


@dc.dataclass(frozen=True)
class SensorNoise:
    """The imperfections of an RGB-D camera; by default, it has none.

    At depth z and angle of incidence theta, the standard deviation of depth is

        axial_floor + axial_growth (z - axial_start)^2
        + axial_grazing theta^2 / (sqrt(z) (pi/2 - theta)^2).

    Attributes:
        axial_floor: Least standard deviation of depth [m].
        axial_growth: Growth of the depth noise with the squared distance [1/m].
        axial_start: Depth at which the growth starts [m].
        axial_grazing: Growth of the depth noise with the angle of incidence
            [m^1.5].
        inverse_depth_step: Step of 1/z between two disparities [1/m]; 0 means
            that depth is not rounded.
        outline_jitter: Standard deviation of shifts of outlines [pixels].
        outline_loss: Probability that a pixel at an outline has no depth.
        dropout: Probability that any other pixel has no depth.
        max_incidence: Angle of incidence beyond which surfaces have no depth
            [rad].
        min_range: Depth below which surfaces have no depth [m].
        max_range: Depth beyond which surfaces have no depth [m].
        color_noise: Standard deviation of each colour channel [grey levels].
        color_gain: Relative standard deviation of each image's exposure.
        position: Standard deviation of each camera's position along each axis
            [m].
        rotation: Standard deviation of each camera's rotation about each axis
            [rad].
    """

    axial_floor: float = 0.0
    axial_growth: float = 0.0
    axial_start: float = 0.0
    axial_grazing: float = 0.0
    inverse_depth_step: float = 0.0
    outline_jitter: float = 0.0
    outline_loss: float = 0.0
    dropout: float = 0.0
    max_incidence: float = np.pi / 2
    min_range: float = 0.0
    max_range: float = np.inf
    color_noise: float = 0.0
    color_gain: float = 0.0
    position: float = 0.0
    rotation: float = 0.0

    def axial(self, z: np.ndarray, incidence: np.ndarray) -> np.ndarray:
        """Computes the standard deviation [m] of depths at incidences [rad]."""
        spread = self.axial_floor + self.axial_growth * np.square(
            z - self.axial_start
        )
        if self.axial_grazing:
            left = np.maximum(np.pi / 2 - incidence, 1e-3)
            steepness = np.square(incidence / left) / np.sqrt(z)
            spread = spread + self.axial_grazing * steepness
        return spread


PRESETS = {
    "none": SensorNoise(),
    # Axial and lateral noise: Nguyen et al. Steps: Khoshelham and Elberink,
    # "Accuracy and resolution of Kinect depth data" (Sensors 2012): 2.85 mm at
    # 1 m. Range: Microsoft's near mode. The colours are an estimate.
    "kinect": SensorNoise(
        axial_floor=0.0012,
        axial_growth=0.0019,
        axial_start=0.4,
        axial_grazing=1e-4,
        inverse_depth_step=0.00285,
        outline_jitter=0.8,
        outline_loss=0.3,
        max_incidence=np.deg2rad(82),
        min_range=0.4,
        max_range=4.0,
        color_noise=3.0,
        color_gain=0.02,
    ),
    # Stereo at 848 x 480: 424 pixels focal length, 50 mm baseline, 0.08 pixels
    # RMS and 1/32 pixel steps of disparity, as in Intel's white papers on
    # tuning the D400 series; nearest 0.28 m and best below 3 m (data sheet).
    # Outlines, angle, dropout and colours are estimates.
    "realsense_d435": SensorNoise(
        axial_growth=0.08 / (424 * 0.05),
        inverse_depth_step=1 / 32 / (424 * 0.05),
        outline_jitter=1.0,
        outline_loss=0.4,
        dropout=0.005,
        max_incidence=np.deg2rad(80),
        min_range=0.28,
        max_range=3.0,
        color_noise=3.0,
        color_gain=0.02,
    ),
}
"""Noise models of known cameras, by name."""


def sensor_noise(name: str) -> SensorNoise:
    """Returns the noise model of a named camera.

    Raises:
        RemoSplatError: The name is not in `PRESETS`.
    """
    if name not in PRESETS:
        raise RemoSplatError(unknown_name("noise preset", name, PRESETS))
    return PRESETS[name]


def with_noise(capture: Capture, noise: SensorNoise, seed: int = 0) -> Capture:
    """Adds the noise of a real camera to a capture.

    The noise of a view depends only on the seed and on the view's index.

    Args:
        capture: A noise-free capture.
        noise: The camera's imperfections.
        seed: Seed of the random noise.
    """
    X_WC = capture.X_WC.copy()
    rgb, depth = np.empty_like(capture.rgb), np.empty_like(capture.depth)
    for i in range(len(capture)):
        rng = np.random.default_rng([seed, i])
        depth[i] = noisy_depth(capture.K[i], capture.depth[i], noise, rng)
        rgb[i] = _noisy_color(capture.rgb[i], noise, rng)
        X_WC[i] = _noisy_pose(capture.X_WC[i], noise, rng)
    return dc.replace(capture, X_WC=X_WC, rgb=rgb, depth=depth)


def noisy_depth(
    K: np.ndarray,
    depth: np.ndarray,
    noise: SensorNoise,
    rng: np.random.Generator,
) -> np.ndarray:
    """Adds the noise of a real sensor to a depth image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Noise-free depth, shape (h, w) [m]; 0 where unknown.
        noise: The camera's imperfections.
        rng: Source of randomness.

    Returns:
        Shape (h, w) [m]; 0 where unknown.
    """
    incidence = _incidence(K, depth)
    outline = near_outline(depth)
    z = _with_jittered_outline(depth, outline, noise.outline_jitter, rng)
    known = (z > 0) & (z >= noise.min_range) & (z <= noise.max_range)
    known &= outline | (incidence <= noise.max_incidence)
    loss = np.where(outline, noise.outline_loss, noise.dropout)
    known &= rng.random(z.shape) >= loss
    z = np.where(known, z, 1.0)
    facing = np.where(outline, 0.0, incidence)
    z = z + rng.standard_normal(z.shape) * noise.axial(z, facing)
    known &= z > 0
    if noise.inverse_depth_step:
        step = noise.inverse_depth_step
        z = 1 / (step * np.maximum(np.rint(1 / (step * np.abs(z))), 1))
    return np.where(known, z, 0).astype(depth.dtype)


def _incidence(K: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Angles between the rays and the surface's normal, (h, w) [rad].

    The angle is 0 where the depth of a neighbour is unknown.
    """
    p_C = back_project(K, depth, np.eye(4))
    along_v, along_u = np.gradient(p_C, axis=(0, 1))
    normal = np.cross(along_u, along_v)
    size = np.linalg.norm(normal, axis=-1) * np.linalg.norm(p_C, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.abs((normal * p_C).sum(axis=-1)) / size
    return np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), 0, 1))


def near_outline(depth: np.ndarray) -> np.ndarray:
    """Finds the pixels that are near a jump of the depth.

    On a plane of any slope, 1/z is linear in the pixel. So second differences
    of 1/z show jumps.

    Args:
        depth: Depth z, shape (h, w) [m]; 0 where unknown.

    Returns:
        Shape (h, w), bool.
    """
    inverse = 1 / np.where(depth > 0, depth, np.inf)
    jump = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        bend = np.abs(np.diff(inverse, n=2, axis=axis))
        inner = [slice(None), slice(None)]
        inner[axis] = slice(1, -1)
        nearest = maximum_filter(inverse, 3)[tuple(inner)]
        jump[tuple(inner)] |= bend > _OUTLINE_JUMP * nearest
    return maximum_filter(jump, 2 * _OUTLINE_REACH - 1)


def _with_jittered_outline(
    depth: np.ndarray,
    outline: np.ndarray,
    jitter: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Gives pixels at an outline the depth of a random neighbour."""
    if not jitter:
        return depth.astype(float)
    offset = np.rint(jitter * rng.standard_normal((2, *depth.shape)))
    rows, columns = np.indices(depth.shape) + outline * offset.astype(int)
    height, width = depth.shape
    return depth[rows.clip(0, height - 1), columns.clip(0, width - 1)].astype(
        float
    )


def _noisy_color(
    rgb: np.ndarray, noise: SensorNoise, rng: np.random.Generator
) -> np.ndarray:
    if not (noise.color_noise or noise.color_gain):
        return rgb
    gain = 1 + noise.color_gain * rng.standard_normal()
    color = gain * rgb + noise.color_noise * rng.standard_normal(rgb.shape)
    return np.rint(color).clip(0, 255).astype(np.uint8)


def _noisy_pose(
    X_WC: np.ndarray, noise: SensorNoise, rng: np.random.Generator
) -> np.ndarray:
    """Adds a small random motion in C to a pose."""
    X_CD = np.eye(4)
    turn = noise.rotation * rng.standard_normal(3)
    X_CD[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    X_CD[:3, 3] = noise.position * rng.standard_normal(3)
    return X_WC @ X_CD
