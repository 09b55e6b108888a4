"""`ShapePairs`: the convex shapes of pairs of links, as arrays for kernels."""

import dataclasses as dc
from collections.abc import Sequence
from itertools import chain

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pair_arrays import (
    PairArrays,
    ShapeArrays,
)
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    ConvexShape,
)

LinkPair = tuple[str, str]
"""Names of two links, the one nearer to the root first."""


@dc.dataclass(frozen=True, eq=False)
class ShapePairs:
    """All k pairs of shapes on l pairs of links.

    Attributes:
        links: The pairs of links, length l.
        first: The shape on the first link of each pair, shape (k,).
        second: The shape on the second link, shape (k,).
        start: For each pair of links, the index of its first pair of shapes;
            the last entry is k, shape (l + 1,).
        boxes: For each pair of links, the indices in `link_boxes` of the boxes
            around their shapes, shape (l, 2).
        shapes: The shapes packed for kernels.
        link_boxes: One box for each link, packed like the shapes.
    """

    links: tuple[LinkPair, ...]
    first: np.ndarray
    second: np.ndarray
    start: np.ndarray
    boxes: np.ndarray
    shapes: ShapeArrays
    link_boxes: ShapeArrays

    @staticmethod
    def make(
        robot: RobotModel, shapes: CollisionShapes, links: Sequence[LinkPair]
    ) -> "ShapePairs":
        """Lists the pairs of shapes on some pairs of links.

        Args:
            robot: The robot.
            shapes: The robot's convex shapes.
            links: The pairs of links.
        """
        on_link: dict[str, list[int]] = {}
        for i, link in enumerate(shapes.links):
            on_link.setdefault(link, []).append(i)
        pairs = [
            [(i, j) for i in on_link[a] for j in on_link[b]] for a, b in links
        ]
        rows = np.array(list(chain(*pairs)), np.int64).reshape(-1, 2)
        names = list(on_link)
        around = CollisionShapes(
            tuple(names), tuple(_box(shapes.of(link)) for link in names)
        )
        boxes = [(names.index(a), names.index(b)) for a, b in links]
        return ShapePairs(
            tuple(links),
            rows[:, 0].copy(),
            rows[:, 1].copy(),
            np.cumsum([0, *map(len, pairs)]).astype(np.int64),
            np.array(boxes, np.int64).reshape(-1, 2),
            _with_bodies(robot, shapes),
            _with_bodies(robot, around),
        )

    def __len__(self) -> int:
        return len(self.first)

    def arrays(self, allowance: np.ndarray) -> Packed[PairArrays]:
        """Returns the pairs packed for kernels.

        Args:
            allowance: Length that is added to each pair's distance, shape (k,)
                [m].
        """
        return Packed(
            PairArrays(
                self.first,
                self.second,
                self.start,
                allowance,
                self.boxes,
                self.shapes,
                self.link_boxes,
            )
        )


def _box(shapes: list[ConvexShape]) -> ConvexShape:
    """Returns the corners of the box around shapes, along the link's axes."""
    lower = np.min([s.vertices.min(axis=0) - s.radius for s in shapes], axis=0)
    upper = np.max([s.vertices.max(axis=0) + s.radius for s in shapes], axis=0)
    corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True)), axis=-1)
    return ConvexShape(corners.reshape(-1, 3))


def _with_bodies(robot: RobotModel, shapes: CollisionShapes) -> ShapeArrays:
    body = np.array([robot.tree.index(x) for x in shapes.links], np.int64)
    return shapes.arrays(body)
