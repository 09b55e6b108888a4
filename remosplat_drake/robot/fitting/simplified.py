"""Simplifies meshes, for uses that need no exact surface."""

import numpy as np


def welded(surface: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merges equal corners of a surface into vertices.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].

    Returns:
        The vertices, shape (v, 3) [m], and the vertex indices of each triangle
        with three different corners, shape (s, 3).
    """
    vertices, triangles = np.unique(
        surface.reshape(-1, 3).round(7), axis=0, return_inverse=True
    )
    triangles = triangles.reshape(-1, 3)
    a, b, c = triangles.T
    return vertices, triangles[(a != b) & (b != c) & (c != a)]


def clustered(surface: np.ndarray, edge: float) -> np.ndarray:
    """Moves all corners in a cell of a grid to one point.

    A closed surface stays closed. It winds around the same points as before,
    except for points nearer to it than a cell's diagonal.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].
        edge: Edge of a cell [m].

    Returns:
        The triangles whose corners are in three different cells, shape (s, 3,
        3) [m].
    """
    p = surface.reshape(-1, 3)
    _, first, cell = np.unique(
        grid_cells(p, edge), return_index=True, return_inverse=True
    )
    a, b, c = cell.reshape(-1, 3).T
    apart = (a != b) & (b != c) & (c != a)
    return p[first][cell.reshape(-1, 3)[apart]]


def grid_cells(p: np.ndarray, edge: float) -> np.ndarray:
    """Returns the index of the grid cell that contains each point, shape (n,).

    Args:
        p: Points, shape (n, 3) [m].
        edge: Edge of a cell [m].
    """
    cell = np.floor(p / edge).astype(np.int64)
    cell -= cell.min(axis=0)
    x, y, z = cell.T
    _, n_y, n_z = (cell.max(axis=0) + 1).tolist()
    return (x * n_y + y) * n_z + z
