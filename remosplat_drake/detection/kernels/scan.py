"""Finds points of a depth image that belong to neither map nor robot.

Distances to the map are stored at the nodes of a grid, in steps of `STEP`, and
interpolated. At a thin surface, the distance has a minimum that interpolation
overestimates by up to half the distance between nodes. A margin of this size
prevents false detections on the map's surfaces.
"""

import math

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.detection.kernels.robot_mask import is_robot

STEP = 0.002
"""Unit of the distances that are stored at nodes [m]."""

FAR = 250
"""Value of nodes that are at least `FAR` steps from the map."""

UNASKED = 255
"""Value of nodes whose distance has not been requested."""

ASKED = 254
"""Value of nodes whose distance has just been requested."""


@helper
def _distance(nodes, i, j, k, fi, fj, fk):
    """Interpolates the distance to the map within a cell [m]."""
    total = 0.0
    for corner in range(8):
        a, b, c = corner & 1, (corner >> 1) & 1, corner >> 2
        share = fi if a else 1.0 - fi
        share *= fj if b else 1.0 - fj
        share *= fk if c else 1.0 - fk
        total += share * nodes[i + a, j + b, k + c]
    return STEP * total


@helper
def _ask(nodes, i, j, k, asked, count):
    """Requests the distances of the nodes of a cell that are still unknown."""
    for corner in range(8):
        a, b, c = i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2)
        if nodes[a, b, c] == UNASKED and count < len(asked):
            nodes[a, b, c] = ASKED
            asked[count] = (a * nodes.shape[1] + b) * nodes.shape[2] + c
            count += 1
    return count


@helper
def _is_unasked(nodes, i, j, k) -> bool:
    for corner in range(8):
        a, b, c = i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2)
        if nodes[a, b, c] >= ASKED:
            return True
    return False


@helper
def _agreeing(depth, row, column, z, allowed):
    """Returns the number of the eight neighbours that show the same surface."""
    count = 0
    for r in range(max(row - 1, 0), min(row + 2, depth.shape[0])):
        for c in range(max(column - 1, 0), min(column + 2, depth.shape[1])):
            if abs(depth[r, c] - z) <= allowed:
                count += 1
    return count - 1


@kernel
def scan(
    depth, K, X_WC, stride, nodes, lower, node, rules, balls_C, asked, found
):
    """Scans an image for new points.

    Args:
        depth: Depth image, shape (h, w), float32 [m].
        K: Intrinsic matrix, shape (3, 3) [pixels].
        X_WC: Camera pose, shape (4, 4).
        stride: Step between examined pixels, and between examined rows.
        nodes: Distances to the map at the nodes of a grid, shape (nx, ny, nz),
            uint8. Nodes whose distances are requested are marked.
        lower: Position of the first node in W, shape (3,) [m].
        node: Distance between nodes [m].
        rules: Seven settings, shape (7,): range [m], standard deviation of a
            depth [m] and its growth [1/m], number of standard deviations, error
            of the camera's pose [m], margin around the robot [m], height of the
            floor [m].
        balls_C: The robot's spheres: centres in C and radii, shape (n, 4) [m].
        asked: Output: flat indices of nodes whose distances must be computed
            before the scan is complete.
        found: Output: positions in W and depths of new points, shape (h w, 4)
            [m].

    Returns:
        Three counts: pixels that show a surface within the box, nodes in
        `asked`, and points in `found`. The points are complete if no node is in
        `asked`.
    """
    height, width = depth.shape
    far, floor, growth, sigmas = rules[0], rules[1], rules[2], rules[3]
    n_known, n_asked, n_found = 0, 0, 0
    start = stride // 2
    pitch = 1.0 / K[0, 0]
    for row in range(start, height, stride):
        y = (row + 0.5 - K[1, 2]) / K[1, 1]
        for column in range(start, width, stride):
            z = float(depth[row, column])
            if not 0.0 < z <= far:
                continue
            x = (column + 0.5 - K[0, 2]) / K[0, 0]
            px = X_WC[0, 0] * x + X_WC[0, 1] * y + X_WC[0, 2]
            py = X_WC[1, 0] * x + X_WC[1, 1] * y + X_WC[1, 2]
            pz = X_WC[2, 0] * x + X_WC[2, 1] * y + X_WC[2, 2]
            px = X_WC[0, 3] + z * px
            py = X_WC[1, 3] + z * py
            pz = X_WC[2, 3] + z * pz
            gi, gj = (px - lower[0]) / node, (py - lower[1]) / node
            gk = (pz - lower[2]) / node
            i, j, k = math.floor(gi), math.floor(gj), math.floor(gk)
            if not (
                0 <= i < nodes.shape[0] - 1
                and 0 <= j < nodes.shape[1] - 1
                and 0 <= k < nodes.shape[2] - 1
            ):
                continue
            n_known += 1
            deviation = sigmas * (floor + growth * z * z)
            margin = deviation + rules[4]
            if pz <= rules[6] + margin:
                continue
            if _is_unasked(nodes, i, j, k):
                n_asked = _ask(nodes, i, j, k, asked, n_asked)
                continue
            apart = _distance(nodes, i, j, k, gi - i, gj - j, gk - k)
            if apart <= margin + 0.5 * node:
                continue
            steep = deviation + 3.0 * pitch * z
            if _agreeing(depth, row, column, z, steep) < 2:
                continue
            if is_robot(x, y, z, deviation, balls_C, rules[5]):
                continue
            found[n_found, 0], found[n_found, 1] = px, py
            found[n_found, 2], found[n_found, 3] = pz, z
            n_found += 1
    return n_known, n_asked, n_found
