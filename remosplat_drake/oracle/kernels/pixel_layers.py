"""`PixelLayers`: all pixels of a view, and the pixels of a coarse grid (Numba).

A layer is a set of the view's rows and columns. It numbers its rows and columns
separately; these numbers are called places.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH

EVERY, GRID = range(2)
"""The two layers of a view: all pixels, and the pixels of the coarse grid."""

_SPACING = 5
"""Number of pixels from one row or column of the grid to the next."""


class PixelLayers(NamedTuple):
    """The two layers of a view: its r x r pixels, and a coarse grid of them.

    Arrays are padded for SIMD lanes.

    Attributes:
        axis: Ray coordinate at each place of both layers, shape (2, r + 8).
        index: Row or column of the view at each place of both layers, shape (2,
            r + 8).
        place: Place of each row or column in both layers, shape (2, r). It is a
            very negative number, which no lane reaches, if the layer lacks the
            row or column.
        place_from: First place at or after each row or column, shape (2, r +
            1).
        beside_grid: 1 for columns that are not in the grid, else 0, shape (r +
            8,).
        length: Length of the ray (x, y, 1) of each pixel, row by row, first of
            the layer of all pixels and then of the grid.
        length_from: Index in `length` at which each row begins, shape (2, r).
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
    # The grid includes the edges of the view, so that every splat that covers
    # many rows or columns covers a grid pixel.
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
    """Stacks two rows of different lengths, which are padded with zeros."""
    table = np.zeros((len(rows), max(map(len, rows)) + WIDTH))
    for row, numbers in zip(table, rows, strict=True):
        row[: len(numbers)] = numbers
    return table
