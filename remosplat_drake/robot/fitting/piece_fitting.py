"""As many convex pieces a link as its distances from other links need.

All links begin with one piece a mesh. Where pieces say in some posture that
two links are nearer than their meshes are, the link whose pieces stand out more
there is cut finer, until the distances are true or nothing finer is allowed.
Links that nothing comes near keep their hulls, which is what keeps ticks fast.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.robot.fitting.convex_pieces import ConvexPiece
from remosplat_drake.robot.fitting.decomposition import decompose
from remosplat_drake.robot.fitting.mesh_truth import MeshTruth, PairError
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    ConvexShape,
)

ACCURACY = 5e-3
"""How much nearer links may be by their pieces than by their meshes [m]."""

_AIM = 4e-3
"""What errors are brought below, so that postures which were not looked at keep
`ACCURACY`, too [m]."""

_TRUE = 1.5e-3
"""How far a piece may stand out where it is not worth cutting: as far as points
on a surface are from each other's middles [m]."""

_LADDER = (np.inf, 0.02, 0.01, 0.006, 0.004, 0.0025)
"""How far pieces may stand out of their mesh, one after the other [m]."""

MOST_PIECES = 40
"""Most pieces that a mesh is cut into."""


@dc.dataclass
class _Link:
    """The meshes of one link, and the pieces that they are cut into."""

    meshes: list[np.ndarray]
    pieces: list[list[ConvexPiece]]
    step: int = 0
    done: bool = False

    def refine(self) -> bool:
        """Cuts the meshes finer; returns whether that changed anything."""
        while not self.done:
            self.step += 1
            self.done = self.step == len(_LADDER) - 1
            before = len(self.all_pieces)
            for i, mesh in enumerate(self.meshes):
                pieces = decompose(mesh, _LADDER[self.step])
                if len(pieces) > MOST_PIECES:
                    self.done = True
                else:
                    self.pieces[i] = pieces
            if len(self.all_pieces) > before:
                return True
        return False

    @property
    def all_pieces(self) -> list[ConvexPiece]:
        return [piece for pieces in self.pieces for piece in pieces]


@dc.dataclass(frozen=True)
class FittedPieces:
    """Convex pieces that cover the meshes of a robot's links.

    Attributes:
        pieces: The pieces of each link that has meshes, by its name, in its
            frame.
        errors: The pairs of links that are nearer by their shapes than by
            their surfaces by more than `ACCURACY`, the worst first.
    """

    pieces: dict[str, list[ConvexPiece]]
    errors: tuple[PairError, ...]

    def __len__(self) -> int:
        return sum(map(len, self.pieces.values()))


def fit_pieces(
    meshes: dict[str, list[np.ndarray]],
    primitives: CollisionShapes,
    truth: MeshTruth,
    on_progress: Callable[[int, int], None] = lambda i, n: None,
) -> FittedPieces:
    """Covers meshes with convex pieces whose distances are theirs.

    Args:
        meshes: Triangles of the meshes of each link, in its frame, shape
            (t, 3, 3) each [m].
        primitives: The other shapes of the links.
        truth: The surfaces of meshes and primitives, in some postures.
        on_progress: Called with the number of links that are settled, and of
            all.

    Raises:
        RemoSplatError: A mesh is flat.
    """
    links = {
        name: _Link(own, [decompose(mesh, _LADDER[0]) for mesh in own])
        for name, own in meshes.items()
    }
    least, best = np.inf, FittedPieces({}, ())
    while True:
        errors = truth.worst_errors(_shapes(links, primitives), _AIM)
        ranked = sorted(errors.values(), key=lambda error: -error.error)
        # A finer cut is another one, and may be worse.
        if (worst := ranked[0].error if ranked else 0.0) < least:
            pieces = {name: link.all_pieces for name, link in links.items()}
            missed = [error for error in ranked if error.error > ACCURACY]
            least, best = worst, FittedPieces(pieces, tuple(missed))
        blamed = {name for error in ranked for name in _suspects(error, links)}
        on_progress(len(links) - len(blamed), len(links))
        refined = [links[name].refine() for name in sorted(blamed)]
        if not any(refined):
            return best


def _suspects(error: PairError, links: dict[str, _Link]) -> list[str]:
    """The link that is to be cut finer, of the two of a pair; none if done."""
    ranked = sorted(zip(error.blame, error.links, strict=True), reverse=True)
    able = [
        name
        for out, name in ranked
        if out > _TRUE and name in links and not links[name].done
    ]
    return able[:1]


def _shapes(
    links: dict[str, _Link], primitives: CollisionShapes
) -> CollisionShapes:
    rows = list(zip(primitives.links, primitives.shapes, strict=True))
    for name, link in links.items():
        rows += [(name, ConvexShape(x.vertices)) for x in link.all_pieces]
    names, shapes = zip(*rows, strict=True)
    return CollisionShapes(names, shapes)
