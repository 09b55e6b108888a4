r"""Errors that all images of a camera share, as displacements of points.

In the camera frame C, a pixel's point is p = z r on the ray r = (x, y, 1). Each
error e_k of the camera displaces the point by e_k b_k(p), to first order:

    depth scale, offset, growth       b = p, r, z^2 r
    focal length, ratio f_y / f_x     b = -(p_x, p_y, 0), -(0, p_y, 0)
    principal point, in f_x and f_y   b = -(z, 0, 0), -(0, z, 0)
    radial distortion k_1, k_2        b = -s (p_x, p_y, 0), -s^2 (p_x, p_y, 0),
                                          s = x^2 + y^2
    delay of the images               b = v + omega x p
    read-out, from top to bottom      b = (row / height - 1/2) (v + omega x p)
    the camera's pose on its carrier  b = e_i x p, e_i

with the camera's velocity v and angular velocity omega in C. The errors can be
estimated, because two views of a surface must place it at the same position.
"""

import dataclasses as dc
from typing import Annotated, Self

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import numpy_helper, numpy_kernel
from remosplat_drake.base.ranges import Config
from remosplat_drake.capture.capture import Capture

SCALE, OFFSET, GROWTH, FOCAL, ASPECT, CENTER_X, CENTER_Y, K1, K2 = range(9)
DELAY, READOUT, TURN, SHIFT = 9, 10, 11, 14
COUNT = 17
"""Indices of the errors in arrays. TURN and SHIFT are the first of three
indices each.
"""

CARRIED = np.array([DELAY, *range(TURN, COUNT)])
"""Indices of the errors that affect only the camera's poses, not its images."""

NO_ERRORS = np.zeros(0)
"""The errors of a camera that is assumed exact: an empty array."""


_Part = Annotated[float, Interval(ge=0, le=1)]
_Length = Annotated[float, Interval(ge=0, le=1)]
_Time = Annotated[float, Interval(ge=0, le=10)]


@dc.dataclass(frozen=True)
class CameraPrior(Config):
    """Prior standard deviations of a camera's errors.

    A deviation of zero means that the parameter is exact. Raises FieldError if
    a value is out of range.

    Attributes:
        scale: Relative error of the depth, as in a sensor's data sheet.
        offset: Offset of the depth [m].
        growth: Growth of the depth's error with its square [1/m].
        focal: Focal length, as a fraction of the focal length.
        aspect: Ratio of the vertical to the horizontal focal length.
        center: Principal point, as a fraction of the focal length.
        distortion: Remaining radial distortion, k_1 and k_2 alike.
        delay: Time from a pose to its image [s].
        readout: Time from the first row of an image to the last one [s].
        turn: Rotation of the camera on its carrier, about each axis [rad].
        shift: Position of the camera on its carrier, along each axis [m].
    """

    scale: _Part = 0.02
    offset: _Length = 0.003
    growth: _Part = 0.005
    focal: _Part = 0.02
    aspect: _Part = 0.003
    center: _Part = 0.005
    distortion: _Part = 0.03
    delay: _Time = 0.05
    readout: _Time = 0.02
    turn: Annotated[float, Interval(ge=0, le=np.pi)] = np.deg2rad(0.5)
    shift: _Length = 0.003

    @classmethod
    def exact(cls, scale: float) -> Self:
        """Returns a prior in which only scale and offset of depths are inexact.

        Args:
            scale: Standard deviation of the depth's scale.
        """
        known = {field.name: 0.0 for field in dc.fields(cls)}
        return cls(**{**known, "scale": scale, "offset": cls.offset})

    def deviations(self) -> np.ndarray:
        """Returns the standard deviation of each error, shape (`COUNT`,)."""
        single = [self.scale, self.offset, self.growth, self.focal]
        lens = [self.center, self.center, self.distortion, self.distortion]
        times = [self.delay, self.readout]
        mount = [self.turn] * 3 + [self.shift] * 3
        return np.array([*single, self.aspect, *lens, *times, *mount])


def velocity_C(capture: Capture, view: int) -> np.ndarray:
    """Returns the velocity of a view's camera in its own frame C.

    Returns:
        Angular velocity of the camera, then the velocity of its centre, shape
        (6,) [rad/s, m/s]; 0 if the capture does not contain it.
    """
    if capture.velocity_W is None:
        return np.zeros(6)
    both = capture.velocity_W[view].reshape(2, 3)
    return (both @ capture.X_WC[view, :3, :3]).ravel()


@numpy_helper
def add_displacements(camera, height, velocity_C, x, y, z, out):
    """Writes the displacements b_k of a pixel's point by each camera error.

    Args:
        camera: f_x, f_y, c_x, c_y of the view [pixels].
        height: Height of its image [pixels].
        velocity_C: Angular velocity of the camera, then the velocity of its
            centre, in C, shape (6,) [rad/s, m/s].
        x: Slope of the pixel's ray, to the right.
        y: Slope of the pixel's ray, downwards.
        z: Its depth [m].
        out: Receives the displacements in C, shape (`COUNT`, 3); with shape (0,
            3), nothing is computed.
    """
    if len(out) == 0:
        return
    out[:] = 0
    px, py = z * x, z * y
    square = x * x + y * y
    row = (camera[1] * y + camera[3]) / height - 0.5
    for axis, p, r in ((0, px, x), (1, py, y), (2, z, 1.0)):
        out[SCALE, axis] = p
        out[OFFSET, axis] = r
        out[GROWTH, axis] = z * z * r
        if axis < 2:
            out[FOCAL, axis] = -p
            out[K1, axis] = -square * p
            out[K2, axis] = -square * square * p
        out[SHIFT + axis, axis] = 1
    out[ASPECT, 1] = -py
    out[CENTER_X, 0] = out[CENTER_Y, 1] = -z
    out[TURN, 1], out[TURN, 2] = -z, py
    out[TURN + 1, 0], out[TURN + 1, 2] = z, -px
    out[TURN + 2, 0], out[TURN + 2, 1] = -py, px
    for axis in range(3):
        moving = velocity_C[3 + axis]
        for k in range(3):
            moving += velocity_C[k] * out[TURN + k, axis]
        out[DELAY, axis] = moving
        out[READOUT, axis] = row * moving


@numpy_kernel
def displacements(camera, height, velocity_C, p_C, out):
    """Writes the displacements of points by each error of their camera.

    Args:
        camera: f_x, f_y, c_x, c_y of the view [pixels].
        height: Height of its image [pixels].
        velocity_C: Its velocity, see `add_displacements`.
        p_C: The points, shape (n, 3) [m].
        out: Receives the displacements in C, shape (n, `COUNT`, 3).
    """
    for i in range(len(p_C)):
        z = p_C[i, 2]
        x, y = p_C[i, 0] / z, p_C[i, 1] / z
        add_displacements(camera, height, velocity_C, x, y, z, out[i])


def displacements_of(
    capture: Capture, view: int, p_C: np.ndarray
) -> np.ndarray:
    """Computes the displacements of a view's points by unit camera errors.

    Args:
        capture: Posed RGB-D images.
        view: Index of the view.
        p_C: Points that the view measured, in C, shape (n, 3) [m].

    Returns:
        The displacement of each point by each of the `COUNT` errors, the
        vectors b_k in C, shape (n, `COUNT`, 3).
    """
    K = capture.K[view]
    camera = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]], float)
    out = np.empty((len(p_C), COUNT, 3))
    height, p_C = float(capture.size[0]), np.ascontiguousarray(p_C, float)
    displacements(camera, height, velocity_C(capture, view), p_C, out)
    return out
