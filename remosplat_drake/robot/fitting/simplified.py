"""Meshes with fewer triangles, for uses that need no exact surface."""

import numpy as np


def welded(surface: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Finds the vertices of a surface, equal corners being one.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].

    Returns:
        The vertices, shape (v, 3) [m], and for each triangle that is more than
        a line the three that are its corners, shape (s, 3).
    """
    vertices, triangles = np.unique(
        surface.reshape(-1, 3).round(7), axis=0, return_inverse=True
    )
    triangles = triangles.reshape(-1, 3)
    a, b, c = triangles.T
    return vertices, triangles[(a != b) & (b != c) & (c != a)]


def clustered(surface: np.ndarray, edge: float) -> np.ndarray:
    """Moves all corners of a grid's cell to one place.

    A closed surface stays closed, so that it winds around the same points
    except for those that are nearer to it than a cell's diagonal.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].
        edge: Edge of a cell [m].

    Returns:
        The triangles whose corners are in three cells, shape (s, 3, 3) [m].
    """
    p = surface.reshape(-1, 3)
    _, first, cell = np.unique(
        grid_cells(p, edge), return_index=True, return_inverse=True
    )
    a, b, c = cell.reshape(-1, 3).T
    apart = (a != b) & (b != c) & (c != a)
    return p[first][cell.reshape(-1, 3)[apart]]


def grid_cells(p: np.ndarray, edge: float) -> np.ndarray:
    """Returns the number of the grid's cell in which each point is, shape (n,).

    Args:
        p: Points, shape (n, 3) [m].
        edge: Edge of a cell [m].
    """
    cell = np.floor(p / edge).astype(np.int64)
    cell -= cell.min(axis=0)
    x, y, z = cell.T
    _, n_y, n_z = (cell.max(axis=0) + 1).tolist()
    return (x * n_y + y) * n_z + z
