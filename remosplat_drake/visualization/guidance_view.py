"""`GuidanceView`: draws the rollouts of the guidance selector on the page."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Rgba
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.controller.guidance.rollout import Rollout
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.visualization.legend import FUTURE
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.shapes import tube_mesh

FUTURES = f"{ROOT}/futures"

_CHOSEN, _OTHER = (
    Rgba(FUTURE.r(), FUTURE.g(), FUTURE.b(), alpha) for alpha in (0.95, 0.25)
)
_MIN_STEP = 0.004  # Shorter steps of a path are skipped [m].
_PERIOD = 0.4  # Shortest time between two drawings [s].


class GuidanceView(LeafSystem):
    """Draws the end-effector paths of guidance's latest rollouts.

    .. pydrake_system::

        name: GuidanceView
        input_ports:
        - selection

    `selection` takes the `Selection` of a `GuidanceSelector`. The path of the
    chosen candidate is solid; the paths of all other candidates are faint. A
    line of text names the chosen candidate.

    Args:
        page: The page to draw on.
    """

    def __init__(self, *, page: MeshcatPage):
        super().__init__()
        self.set_name("guidance_view")
        self._page = page
        self._drawn: tuple[Rollout, ...] = ()
        self._drawn_at = -np.inf
        self._selection_input = self.DeclareAbstractInputPort(
            "selection", Value(Selection(DIRECT))
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage
    ) -> "GuidanceView":
        """Adds a view to a diagram; the caller connects its port."""
        return builder.AddSystem(GuidanceView(page=page))

    def _publish(self, context: Context):
        selection = self._selection_input.Eval(context)
        name, missing = selection.guidance.name, selection.missing
        self._page.set_status(name, "guidance", missing)
        time = context.get_time()
        is_early = 0 <= time - self._drawn_at < _PERIOD
        if selection.latest is self._drawn or is_early:
            return
        self._drawn, self._drawn_at = selection.latest, time
        self._page.meshcat.Delete(FUTURES)
        for i, rollout in enumerate(selection.latest):
            self._draw(i, rollout, rollout.guidance == selection.guidance)

    def _draw(self, i: int, rollout: Rollout, chosen: bool):
        points = spaced_points(np.array(rollout.path), _MIN_STEP)
        if len(points) < 2:
            return
        vertices, faces = tube_mesh(points, 0.006 if chosen else 0.004)
        self._page.meshcat.SetTriangleMesh(
            f"{FUTURES}/{i}_{rollout.guidance.name}",
            vertices.T,
            faces.T,
            _CHOSEN if chosen else _OTHER,
        )


def spaced_points(p: np.ndarray, step: float) -> np.ndarray:
    """Reduces a path to points at a minimum distance.

    Args:
        p: Points of the path, shape (n, 3) [m].
        step: Consecutive points that are kept are at least this far apart [m].

    Returns:
        The remaining points, including the first one, shape (m, 3) [m].
    """
    kept: list[np.ndarray] = []
    for point in p:
        if not kept or np.linalg.norm(point - kept[-1]) >= step:
            kept.append(point)
    return np.array(kept)
