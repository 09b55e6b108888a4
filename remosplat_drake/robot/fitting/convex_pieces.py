"""Cuts a link's mesh into convex collision shapes.

Contact simulation needs few convex shapes with few corners. These shapes must
not protrude from the spheres that the controller uses. The mesh is therefore
cut along the planes in which spheres intersect. Each part between these planes
lies in one sphere; its convex hull lies in the same sphere. Then hulls are
joined as long as the spheres still enclose the result.
"""

import dataclasses as dc
from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.enclosure import standing_out
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres


@dc.dataclass(frozen=True, eq=False)
class ConvexPiece:
    """A convex polyhedron in the link frame.

    Attributes:
        vertices: Vertices, shape (v, 3) [m].
        triangles: Vertex indices, anticlockwise from outside, shape (t, 3).
        volume: Volume of the polyhedron [m^3].
    """

    vertices: np.ndarray
    triangles: np.ndarray
    volume: float

    @property
    def surface(self) -> np.ndarray:
        """The corners of the triangles, shape (t, 3, 3) [m]."""
        return self.vertices[self.triangles]

    def to_obj(self, comment: str) -> str:
        """Writes the polyhedron as an .obj in micrometres.

        Args:
            comment: First line of the file.
        """
        rows = [f"# {comment}"]
        rows += ["v " + " ".join(f"{x:.6f}" for x in v) for v in self.vertices]
        rows += ["f " + " ".join(str(i + 1) for i in t) for t in self.triangles]
        return "\n".join(rows) + "\n"


def convex_pieces(
    surface: np.ndarray,
    spheres: LinkSpheres,
    tolerance: float,
    filling: float = 0.2,
) -> list[ConvexPiece]:
    """Covers a surface with convex pieces that the link's spheres enclose.

    Args:
        surface: Triangles in the link frame, shape (t, 3, 3) [m].
        spheres: The spheres of that link, which enclose the surface.
        tolerance: Distance by which the surface may protrude from the pieces
            [m]. With a larger tolerance, pieces have fewer corners.
        filling: Two pieces are joined if their common hull adds at most this
            fraction to their volume.

    Raises:
        RemoSplatError: The spheres do not enclose the surface.
    """
    out = standing_out(surface, spheres)
    if out > 0:
        raise RemoSplatError(
            f"the mesh protrudes from the spheres by {1e3 * out:.1f} mm; fit"
            " spheres to this mesh"
        )
    parts = []
    for i in range(len(spheres.radius)):
        part = _in_cell(surface, spheres, i).reshape(-1, 3)
        hull = _hull(part)
        if hull is not None:
            parts.append(part[hull.vertices])
    parts = _joined(parts, spheres, filling)
    return [convex_piece(part, tolerance) for part in parts]


def _in_cell(surface: np.ndarray, spheres: LinkSpheres, i: int) -> np.ndarray:
    """Returns the part of a surface that is deepest in sphere i.

    A point is deepest in the sphere for which its power, distance^2 - radius^2,
    is least. On the plane in which two spheres intersect, their powers are
    equal.
    """
    p_LS, square = spheres.p_LS, spheres.radius**2
    part = surface
    for j in range(len(square)):
        if j != i and len(part):
            normal = 2 * (p_LS[j] - p_LS[i])
            offset = p_LS[j] @ p_LS[j] - p_LS[i] @ p_LS[i]
            part = below(part, normal, offset - square[j] + square[i])
    return part


def below(part: np.ndarray, normal: np.ndarray, offset: float) -> np.ndarray:
    """Returns the part of a surface where normal . p <= offset.

    Args:
        part: Triangles, shape (t, 3, 3) [m].
        normal: Normal of the cutting plane, shape (3,).
        offset: Right-hand side of the inequality [m, if the normal is a unit
            vector].

    Returns:
        Triangles, shape (s, 3, 3) [m].
    """
    height = part @ normal - offset
    crossing = (height > 0).any(axis=1)
    pieces = [part[~crossing]]
    # Each triangle's corners are rotated so that the first corner is alone on
    # its side of the plane.
    for side, count in ((-1, 1), (1, 2)):
        alone = crossing & ((height < 0).sum(axis=1) == count)
        rows = np.arange(alone.sum())[:, None]
        first = (side * height[alone]).argmax(axis=1)
        order = (first[:, None] + np.arange(3)) % 3
        p, h = part[alone][rows, order], height[alone][rows, order]
        a, b, c = p[:, 0], p[:, 1], p[:, 2]
        share = h[:, :1] / (h[:, :1] - h[:, 1:])
        ab, ac = a + (b - a) * share[:, :1], a + (c - a) * share[:, 1:]
        if side < 0:
            pieces.append(np.stack([a, ab, ac], axis=1))
        else:
            pieces.append(np.stack([ab, b, c], axis=1))
            pieces.append(np.stack([ab, c, ac], axis=1))
    return np.concatenate(pieces)


def _joined(
    parts: list[np.ndarray], spheres: LinkSpheres, filling: float
) -> list[np.ndarray]:
    """Joins the pair of parts whose hull adds least volume, repeatedly."""
    volume = [hull_volume(part) for part in parts]
    alive = list(range(len(parts)))
    candidates = list(combinations(alive, 2))
    joins: dict[tuple[int, int], float] = {}
    while True:
        for i, j in candidates:
            both = np.vstack([parts[i], parts[j]])
            added = hull_volume(both) / (volume[i] + volume[j]) - 1
            hull = _hull(both)
            if (
                hull is not None
                and added <= filling
                and standing_out(hull.points[hull.simplices], spheres) <= 0
            ):
                joins[i, j] = added
        if not joins:
            return [parts[i] for i in alive]
        i, j = min(joins, key=lambda pair: joins[pair])
        alive = [k for k in alive if k not in (i, j)]
        joins = {p: x for p, x in joins.items() if not {i, j} & set(p)}
        new = len(parts)
        parts.append(np.vstack([parts[i], parts[j]]))
        volume.append(hull_volume(parts[-1]))
        candidates = [(k, new) for k in alive]
        alive.append(new)


def _hull(p: np.ndarray) -> ConvexHull | None:
    """The convex hull of points, or None if they are flat or too few."""
    try:
        return ConvexHull(p)
    except (QhullError, ValueError):
        return None


def hull_volume(p: np.ndarray) -> float:
    """Returns the volume of the convex hull of points, 0 if they are flat.

    Args:
        p: Points, shape (n, 3) [m].
    """
    hull = _hull(p)
    return 0.0 if hull is None else float(hull.volume)


def convex_corners(p: np.ndarray) -> np.ndarray:
    """Returns the points that are corners of the convex hull.

    Args:
        p: Points, shape (n, 3) [m].

    Returns:
        The corners, shape (m, 3) [m]; all points if they are flat.
    """
    hull = _hull(p)
    return p if hull is None else p[hull.vertices]


def convex_piece(
    p: np.ndarray, tolerance: float, enough: float = np.inf
) -> ConvexPiece:
    """Makes a hull of a few of the points; no point is far outside of it.

    It starts with the outermost points along the axes and the diagonals. Each
    iteration then adds the farthest point outside each face.

    Args:
        p: Points, shape (n, 3) [m].
        tolerance: Greatest distance of a point outside the hull [m]; 0 keeps
            all corners.
        enough: Number of corners after which no corner is added, even if points
            are farther outside.

    Raises:
        RemoSplatError: The points are flat, or too few.
    """
    whole = _hull(p)
    if whole is None:
        raise RemoSplatError("its points are flat, or too few for a solid")
    if tolerance <= 0.0:
        return _oriented(whole)
    p = p[whole.vertices]
    heights = p @ np.vstack([np.eye(3), -np.eye(3), _DIAGONALS]).T
    chosen = np.unique(heights.argmax(axis=0))
    while True:
        hull = _hull(p[chosen])
        if hull is None:
            # The body is so thin that the chosen points span no volume.
            return _oriented(whole)
        planes = hull.equations
        heights = p @ planes[:, :3].T + planes[:, 3]
        above, face = heights.max(axis=1), heights.argmax(axis=1)
        far = above > max(tolerance, 0.5 * above.max())
        order = np.argsort(-above)
        order = order[far[order]]
        # The first point of each face is the point farthest above the face.
        new = order[np.unique(face[order], return_index=True)[1]]
        new = np.setdiff1d(new, chosen)
        if not len(new) or len(np.unique(hull.simplices)) > enough:
            return _oriented(hull)
        chosen = np.concatenate([chosen, new])


def _oriented(hull: ConvexHull) -> ConvexPiece:
    used, triangles = np.unique(hull.simplices, return_inverse=True)
    vertices = hull.points[used]
    triangles = triangles.reshape(-1, 3)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return ConvexPiece(vertices, triangles, float(hull.volume))


_DIAGONALS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)
