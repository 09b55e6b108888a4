"""Convex shapes and pairs of them, packed for kernels."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH


def vertex_blocks(vertices: np.ndarray) -> np.ndarray:
    """Arranges a hull's vertices in blocks: eight x, eight y, eight z.

    Kernels read eight vertices at a time. The last block is padded with the
    last vertex.

    Args:
        vertices: The vertices, shape (n, 3) [m].

    Returns:
        The blocks, shape (ceil(n / 8), 3, 8) [m].
    """
    missing = -len(vertices) % WIDTH
    filled = np.pad(vertices, ((0, missing), (0, 0)), mode="edge")
    blocks = filled.reshape(-1, WIDTH, 3).transpose(0, 2, 1)
    return np.ascontiguousarray(blocks)


class ShapeArrays(NamedTuple):
    """The s convex shapes of a robot.

    Attributes:
        blocks: Vertices of all shapes, each in its link, in `vertex_blocks`,
            shape (v, 3, 8) [m].
        first: Index of each shape's first block; the last entry is the number
            of blocks, shape (s + 1,).
        radius: Rounding radius of each shape, shape (s,) [m].
        center: Centres of the shapes in their links, shape (s, 3) [m].
        half: Half edges of the boxes around them, along the axes of their
            links, shape (s, 3) [m].
        reach: Greatest distance of a vertex from its centre, shape (s,) [m].
        body: Body of the robot's tree that each shape is fixed to, shape (s,).
    """

    blocks: np.ndarray
    first: np.ndarray
    radius: np.ndarray
    center: np.ndarray
    half: np.ndarray
    reach: np.ndarray
    body: np.ndarray


class PairArrays(NamedTuple):
    """All k pairs of shapes on l pairs of links.

    Attributes:
        first: The shape on the first link of each pair, shape (k,).
        second: The shape on the second link, shape (k,).
        start: For each pair of links, the index of its first pair of shapes;
            the last entry is k, shape (l + 1,).
        allowance: Length that is added to each pair's distance, shape (k,) [m].
        boxes: For each pair of links, the indices in `link_boxes` of the boxes
            around their shapes, shape (l, 2).
        shapes: The shapes.
        link_boxes: One box for each link.
    """

    first: np.ndarray
    second: np.ndarray
    start: np.ndarray
    allowance: np.ndarray
    boxes: np.ndarray
    shapes: ShapeArrays
    link_boxes: ShapeArrays
