"""Lowers the distances that a robot keeps to those at its start."""

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.controller.planning.kernels.map_checks import (
    sphere_margins,
)
from remosplat_drake.robot.kinematics import body_poses
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)


@kernel(returns=NOTHING)
def lower_levels(space, line, start):
    """Lowers the distances that are larger than the distances at the start.

    Args:
        space: The `SpaceArrays`. Input: `level` and `self_level` contain the
            stopping distances. Output: the distances to keep, also in
            `link_level`.
        line: Number of the `PythonCalls` of the map.
        start: Configuration at the start, shape (1, n_q) [rad, m].
    """
    pairs, level = space.self_pairs.pairs, space.self_level
    if len(level) > 0:
        X_WL, _ = body_poses(space.robot.tree, start[0])
        distance = pair_distances(pairs, X_WL, level[0])
        for k in range(len(level)):
            level[k] = min(level[k], distance[k])
    for link in range(len(pairs.boxes)):
        most = -1e9
        for k in range(pairs.start[link], pairs.start[link + 1]):
            most = max(most, level[k] - pairs.allowance[k])
        space.link_level[link] = most
    margins = sphere_margins(space, line, start, 0.0)
    for i in range(len(space.level)):
        space.level[i] += margins[0, i]
