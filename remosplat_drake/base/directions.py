"""Directions that are spread evenly."""

import numpy as np


def spread_directions(n: int) -> np.ndarray:
    """Returns unit vectors evenly over the sphere, on a Fibonacci spiral.

    Args:
        n: Their number.

    Returns:
        Shape (n, 3).
    """
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.arange(n) * np.pi * (3 - np.sqrt(5))
    rho = np.sqrt(1 - z**2)
    return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), z])
