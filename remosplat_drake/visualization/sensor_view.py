"""`SensorView`: draws the depth sensor of one robot sphere on the page."""

import numpy as np
from pydrake.geometry import Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.perception import BaseField, Fields, PointCloud

from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.view_images import SphereViews
from remosplat_drake.visualization.depth_views import range_colors
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.shapes import tube_mesh
from remosplat_drake.visualization.toggle import on_off

SENSOR = f"{ROOT}/sensor"
SEEN = f"{SENSOR}/seen"

_BODY = Rgba(1.0, 0.72, 0.1, 0.55)
_FRUSTUM = Rgba(0.15, 0.20, 0.30)
_NEAR = Rgba(1.0, 0.72, 0.1)
_NEAREST = Rgba(0.95, 0.12, 0.10)
_TUBE_RADIUS = 0.003
_DOT_RADIUS = 0.009
_POINT_SIZE = 0.009
_CORNERS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)


class SensorView:
    """Draws a sphere, the frusta of its six views, and the surfaces they see.

    The frusta of the six views fill a cube, whose edges are drawn. A line joins
    the sensor to the closest point of each view, and a dot marks this point.
    The line to the closest of these points is red. The points that the views
    see have the colours of `draw_depth_views`; a button hides them.

    Args:
        page: The page to draw on.
        views: The six depth views of the sphere.
        depth: Half the side of the cube that the frusta fill [m].
    """

    def __init__(
        self, page: MeshcatPage, views: SphereViews, depth: float = 0.15
    ):
        meshcat = page.meshcat
        meshcat.SetObject(f"{SENSOR}/sphere", Sphere(views.radius), _BODY)
        meshcat.SetTransform(f"{SENSOR}/sphere", RigidTransform(views.p_WS))
        start, end = frustum_edges(views.p_WS, views.R_WD, depth)
        meshcat.SetLineSegments(
            f"{SENSOR}/frusta", start.T, end.T, line_width=1.5, rgba=_FRUSTUM
        )
        _draw_rays(meshcat, views)
        _draw_seen(meshcat, views)
        page.add_toggle(on_off("Seen surface", "4", SEEN))


def frustum_edges(
    p_WS: np.ndarray, R_WD: np.ndarray, depth: float
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the edges of the six views' frusta, up to a depth.

    Args:
        p_WS: Position of the sensor in W, shape (3,) [m].
        R_WD: Rotation of the sensor's frame D in W, shape (3, 3).
        depth: Depth z at which the frusta end [m].

    Returns:
        Both ends, in W, of 8 edges through the sensor and 12 edges of a cube
        around it, shape (20, 3) each [m].
    """
    corner = p_WS + depth * _CORNERS @ R_WD.T
    a, b = np.triu_indices(len(_CORNERS), 1)
    # Two corners of a cube share an edge if they differ in one coordinate.
    edge = (_CORNERS[a] != _CORNERS[b]).sum(axis=1) == 1
    start = np.concatenate([np.tile(p_WS, (8, 1)), corner[a[edge]]])
    return start, np.concatenate([corner, corner[b[edge]]])


def _draw_rays(meshcat: Meshcat, views: SphereViews):
    clearances, points = views.clearances, views.nearest_points
    for view in range(N_VIEWS):
        if not np.isfinite(clearances[view]):
            continue
        color = _NEAREST if view == clearances.argmin() else _NEAR
        path = f"{SENSOR}/closest/{view}"
        vertices, faces = tube_mesh(
            np.array([views.p_WS, points[view]]), _TUBE_RADIUS
        )
        meshcat.SetTriangleMesh(f"{path}/ray", vertices.T, faces.T, color)
        meshcat.SetObject(f"{path}/point", Sphere(_DOT_RADIUS), color)
        meshcat.SetTransform(f"{path}/point", RigidTransform(points[view]))


def _draw_seen(meshcat: Meshcat, views: SphereViews):
    seen = np.isfinite(views.ranges)
    cloud = PointCloud(
        int(seen.sum()), Fields(BaseField.kXYZs | BaseField.kRGBs)
    )
    cloud.mutable_xyzs()[:] = views.p_WP[seen].T
    colors = range_colors(views.ranges[seen])
    cloud.mutable_rgbs()[:] = np.round(255 * colors.T).astype(np.uint8)
    meshcat.SetObject(SEEN, cloud, point_size=_POINT_SIZE)
