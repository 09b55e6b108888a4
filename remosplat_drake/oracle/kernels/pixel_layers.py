"""`PixelLayers`: all pixels of a view, and those of a coarse grid (Numba).

Each layer numbers its rows and columns separately: these numbers are called
places.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH

EVERY, GRID = range(2)
"""The layers of a view: all pixels, and those of the coarse grid."""

_SPACING = 5
"""Number of pixels from one row or column of the grid to the next."""


class PixelLayers(NamedTuple):
    """The layers of a view: all its r x r pixels, and a coarse grid of them.

    Arrays are padded for SIMD lanes.

    Attributes:
        axis: Ray coordinate of each place, shape (2, r + 8).
        index: Row or column of the view at each place, shape (2, r + 8).
        place: Place of each row or column, shape (2, r). If a layer lacks the
            row or column, a very negative number, which no lane reaches.
        place_from: First place at or after a row or column, shape (2, r + 1).
        beside_grid: 1 for columns that are not the grid's, else 0, shape
            (r + 8,).
        length: Length of the ray (x, y, 1) of each pixel, row by row and layer
            after layer.
        length_from: Start of each row in `length`, shape (2, r).
    """

    axis: np.ndarray
    index: np.ndarray
    place: np.ndarray
    place_from: np.ndarray
    beside_grid: np.ndarray
    length: np.ndarray
    length_from: np.ndarray


def make_layers(resolution: int) -> PixelLayers:
    """Makes the layers of a view with resolution x resolution pixels."""
    every = np.arange(resolution)
    # The grid reaches the edges, so that it covers every splat of many rows or
    # columns.
    grid = np.unique(
        np.linspace(0, resolution - 1, 1 + -(-resolution // _SPACING)).round()
    ).astype(np.int64)
    axis = (every + 0.5) * 2 / resolution - 1
    x, y = np.meshgrid(axis, axis)
    length = np.sqrt(x * x + y * y + 1)
    on_grid = np.isin(every, grid)
    before = np.searchsorted(grid, np.arange(resolution + 1))
    return PixelLayers(
        axis=_with_room(axis, axis[grid]),
        index=_with_room(every, grid).astype(np.int64),
        place=np.stack([every, np.where(on_grid, before[:-1], -WIDTH)]),
        place_from=np.stack([np.arange(resolution + 1), before]),
        beside_grid=_with_room(~on_grid)[0],
        length=_with_room(
            np.append(length.reshape(-1), length[grid][:, grid].reshape(-1))
        )[0],
        length_from=np.stack(
            [resolution * every, resolution**2 + len(grid) * every]
        ),
    )


def _with_room(*rows: np.ndarray) -> np.ndarray:
    """Stacks rows of different lengths, padded with zeros."""
    table = np.zeros((len(rows), max(map(len, rows)) + WIDTH))
    for row, numbers in zip(table, rows, strict=True):
        row[: len(numbers)] = numbers
    return table
