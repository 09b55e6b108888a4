"""Finds the pixels of a depth image that may show the robot."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


@helper
def is_robot(x, y, z, slack, balls_C, margin) -> bool:
    """Returns whether the ray (x, y, 1) may meet a sphere before the depth z.

    The error of the ray's position is at most the margin, and the error of the
    depth at most the slack.
    """
    square = x * x + y * y + 1.0
    for s in range(len(balls_C)):
        cx, cy, cz = balls_C[s, 0], balls_C[s, 1], balls_C[s, 2]
        radius = balls_C[s, 3] + margin
        middle = cx * x + cy * y + cz
        offset = cx * cx + cy * cy + cz * cz - radius * radius
        discriminant = middle * middle - square * offset
        if discriminant < 0.0:
            continue
        root = math.sqrt(discriminant)
        if offset <= 0.0:
            # The camera is inside the sphere.
            if (z - slack) * square <= middle + root:
                return True
        elif middle > 0.0 and middle - root <= (z + slack) * square:
            return True
    return False


@kernel
def robot_mask(p_C, depth, slack, balls_C, margin):
    """Marks points whose pixels may show the robot.

    Args:
        p_C: Points before the camera in C, shape (n, 3) [m].
        depth: Measured depths at their pixels, shape (n,) [m].
        slack: Bounds of the errors of these depths, shape (n,) [m].
        balls_C: The robot's spheres: centres in C and radii, shape (m, 4) [m].
        margin: Margin around the spheres [m].

    Returns:
        Mask of the points that may belong to the robot, shape (n,), bool.
    """
    found = np.zeros(len(p_C), np.bool_)
    for i in range(len(p_C)):
        x, y = p_C[i, 0] / p_C[i, 2], p_C[i, 1] / p_C[i, 2]
        found[i] = is_robot(x, y, depth[i], slack[i], balls_C, margin)
    return found
