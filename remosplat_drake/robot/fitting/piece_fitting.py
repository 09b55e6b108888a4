"""Fits convex pieces to links, as many as accurate distances require.

All links begin with one piece for each mesh. If the pieces' distance of two
links is too small in a posture, the piece that protrudes more there is cut in
two by a plane. This is repeated until the distances are accurate or the largest
number of pieces is reached. Links that never come near other links keep their
hulls, so that ticks are fast.
"""

import dataclasses as dc
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from remosplat_drake.robot.fitting.convex_pieces import ConvexPiece
from remosplat_drake.robot.fitting.enclosing_piece import Enclosed
from remosplat_drake.robot.fitting.mesh_truth import MeshTruth, PairError
from remosplat_drake.robot.fitting.plane_cuts import cut_in_two
from remosplat_drake.robot.self_collision.link_pairs import possible_pairs
from remosplat_drake.robot.self_collision.shape_pairs import LinkPair
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    ConvexShape,
)

ACCURACY = 5e-3
"""Distances between the pieces of two links have at most this error [m]."""

_AIM = 4e-3
"""In the examined postures, errors are reduced to this bound, so that errors in
other postures do not exceed `ACCURACY`, either [m]."""

_TRUE = 1.5e-3
"""A piece is not cut at points that protrude from the surface by less than this
[m], about the distance between sampled points of the surface."""

_SEARCHES = 3
"""Number of searches for larger errors. Each search after the first covers only
pairs of links that had errors before, since cuts never increase an error."""

MOST_PIECES = 40
"""A mesh is cut into at most this many pieces."""


@dc.dataclass(eq=False)
class _Part:
    """A part of a mesh, with the convex piece that represents it.

    Attributes:
        of: Surface and piece.
        done: Whether no cut improves it.
    """

    of: Enclosed
    done: bool = False


@dc.dataclass(eq=False)
class _Mesh:
    """A mesh of a link, and the parts that it is cut into."""

    link: str
    parts: list[_Part]

    def cut(self, part: _Part, p: np.ndarray, off: np.ndarray) -> bool:
        """Cuts a part where its piece protrudes; returns whether it did.

        Args:
            part: One of the parts.
            p: Points at which the piece protrudes, shape (n, 3) [m].
            off: Distances of the points from the surface, shape (n,) [m].
        """
        halves = None
        if len(self.parts) < MOST_PIECES:
            halves = cut_in_two(part.of.surface, p, off)
        if halves is None:
            part.done = True
            return False
        i = self.parts.index(part)
        self.parts[i : i + 1] = [_Part(Enclosed.make(x)) for x in halves]
        return True


@dc.dataclass(frozen=True)
class FittedPieces:
    """Convex pieces that cover the meshes of a robot's links.

    Attributes:
        pieces: The pieces of each link that has meshes, by its name, in its
            frame.
        errors: The remaining errors above `ACCURACY`, the largest first.
    """

    pieces: dict[str, list[ConvexPiece]]
    errors: tuple[PairError, ...]

    def __len__(self) -> int:
        return sum(map(len, self.pieces.values()))


@dc.dataclass(frozen=True, eq=False)
class _Blame:
    """An error, with the parts whose pieces are nearest in its posture."""

    error: PairError
    parts: tuple[_Part | None, ...]

    def suspect(self) -> tuple[_Part, np.ndarray, float] | None:
        """Returns the part to cut, a point of its piece, and its protrusion.

        Of the two parts that can be cut, it is the part whose piece protrudes
        more.
        """
        ranked = sorted(
            zip(self.error.blame, self.parts, self.error.points, strict=True),
            key=lambda end: -end[0],
        )
        for off, part, p in ranked:
            if off > _TRUE and part is not None and not part.done:
                return part, p, off
        return None


class _Wrong(NamedTuple):
    """The largest errors of two links, and all postures that may have errors.

    Cuts never increase an error, apart from the slack of the pieces. After a
    cut, only these postures are therefore examined again.
    """

    blames: list[_Blame]
    postures: np.ndarray


def fit_pieces(
    meshes: dict[str, list[Enclosed]],
    primitives: CollisionShapes,
    truth: MeshTruth,
    on_progress: Callable[[int, int], None] = lambda i, n: None,
) -> FittedPieces:
    """Covers meshes with convex pieces that preserve the links' distances.

    Args:
        meshes: The meshes of each link, in its frame.
        primitives: The other shapes of the links.
        truth: The surfaces of meshes and primitives, in some postures.
        on_progress: Called with the number of finished links, and the number of
            links.
    """
    cut = [
        _Mesh(link, [_Part(mesh)])
        for link, own in meshes.items()
        for mesh in own
    ]
    links = [*primitives.links, *meshes]
    pairs, _ = possible_pairs(truth.robot, links)
    wrong: dict[LinkPair, _Wrong] = {}
    searched = pairs
    for search in range(_SEARCHES + 1):
        if search:
            shapes, _ = _shapes(cut, primitives)
            searched = truth.add_worst(shapes, searched, _AIM)
        # Finally, all pairs are examined once more in all postures.
        last = search == _SEARCHES
        again: dict[LinkPair, np.ndarray | None]
        again = dict.fromkeys(pairs if last else searched)
        while again:
            kept = {k: own for k, own in wrong.items() if k not in again}
            wrong = kept | _errors(cut, primitives, truth, again)
            changed = _cut_blamed(cut, wrong)
            again = {
                pair: own.postures
                for pair, own in wrong.items()
                if changed & set(pair)
            }
            on_progress(len(meshes) - len(changed), len(meshes))
    pieces: dict[str, list[ConvexPiece]] = {}
    for mesh in cut:
        own = pieces.setdefault(mesh.link, [])
        own += [part.of.piece for part in mesh.parts]
    worst = [own.blames[0].error for own in wrong.values()]
    missed = [error for error in worst if error.error > ACCURACY]
    missed.sort(key=lambda error: -error.error)
    return FittedPieces(pieces, tuple(missed))


def _errors(
    meshes: list[_Mesh],
    primitives: CollisionShapes,
    truth: MeshTruth,
    among: Mapping[LinkPair, np.ndarray | None],
) -> dict[LinkPair, _Wrong]:
    """Returns the errors of pairs of links, in the given postures."""
    shapes, parts = _shapes(meshes, primitives)
    return {
        pair: _Wrong(
            [_Blame(x, tuple(parts[i] for i in x.shapes)) for x in found.worst],
            found.postures,
        )
        for pair, found in truth.errors(shapes, among, _AIM).items()
    }


def _shapes(
    meshes: list[_Mesh], primitives: CollisionShapes
) -> tuple[CollisionShapes, list[_Part | None]]:
    """Returns all shapes, and the part that each represents (None if none)."""
    parts: list[_Part | None] = [None] * len(primitives)
    links, shapes = list(primitives.links), list(primitives.shapes)
    for mesh in meshes:
        for part in mesh.parts:
            parts.append(part)
            links.append(mesh.link)
            shapes.append(ConvexShape(part.of.piece.vertices))
    return CollisionShapes(tuple(links), tuple(shapes)), parts


def _cut_blamed(meshes: list[_Mesh], wrong: dict[LinkPair, _Wrong]) -> set[str]:
    """Cuts the parts that cause errors; returns which links have changed."""
    changed: set[str] = set()
    # If no part can be cut, the other parts of the pairs are tried.
    while not changed and (suspects := _suspects(wrong)):
        for mesh in meshes:
            for part in [part for part in mesh.parts if part in suspects]:
                p, off = map(np.array, zip(*suspects[part], strict=True))
                if mesh.cut(part, p, off):
                    changed.add(mesh.link)
    return changed


def _suspects(
    wrong: dict[LinkPair, _Wrong],
) -> dict[_Part, list[tuple[np.ndarray, float]]]:
    """Returns the parts to cut, and the points where their pieces protrude."""
    suspects: dict[_Part, list[tuple[np.ndarray, float]]] = {}
    for blame in (blame for own in wrong.values() for blame in own.blames):
        if (suspect := blame.suspect()) is not None:
            part, p, off = suspect
            suspects.setdefault(part, []).append((p, off))
    return suspects
