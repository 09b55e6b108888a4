"""Convex shapes and pairs of them, packed for kernels."""

from typing import NamedTuple

import numpy as np


class ShapeArrays(NamedTuple):
    """The s convex shapes of a robot.

    Attributes:
        vertices: Vertices of all shapes, each in its link, shape (v, 3) [m].
        first: Where each shape's vertices begin, shape (s + 1,).
        radius: By how much each shape is rounded, shape (s,) [m].
        center: Centres of the shapes in their links, shape (s, 3) [m].
        half: Half edges of the boxes around them, along the axes of their
            links, shape (s, 3) [m].
        reach: Greatest distance of a vertex from its centre, shape (s,) [m].
        body: Body of the robot's tree that each is on, shape (s,).
    """

    vertices: np.ndarray
    first: np.ndarray
    radius: np.ndarray
    center: np.ndarray
    half: np.ndarray
    reach: np.ndarray
    body: np.ndarray


class PairArrays(NamedTuple):
    """All k pairs of shapes on l pairs of links.

    Attributes:
        first: The shape on the first link of each, shape (k,).
        second: The shape on the second link, shape (k,).
        start: Where the pairs of shapes of each pair of links begin, shape
            (l + 1,).
        allowance: By how much each pair's distance is counted too large, shape
            (k,) [m].
        boxes: For each pair of links the two boxes that hold their shapes, as
            numbers of `link_boxes`, shape (l, 2).
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
