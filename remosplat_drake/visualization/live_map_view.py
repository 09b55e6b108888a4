"""`LiveMapView`: draws the live map on the page, piece by piece."""

from collections.abc import Iterator

from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.toggle import on_off
from remosplat_drake.visualization.unseen_space import (
    add_unseen_toggle,
    draw_layers,
)

TILES = f"{ROOT}/map/surfels"


class LiveMapView(LeafSystem):
    """Draws the map and the boundary of unseen space.

    .. pydrake_system::

        name: LiveMapView
        input_ports:
        - map_status

    `map_status` takes the `MapStatus`. Each update sends one piece: a tile of
    the splat, or a layer of the boundary. This takes about a millisecond, so
    that a new map does not delay control ticks. The page shows a piece of the
    previous map until its replacement is sent.

    Args:
        page: The page to draw on.
        initial: The first map on the page, which is drawn at once.
        show_unseen: Whether the boundary is visible at first.
    """

    def __init__(
        self, *, page: MeshcatPage, initial: SceneMap, show_unseen: bool
    ):
        super().__init__()
        self.set_name("live_map_view")
        self._page = page
        self._map = initial
        self._pieces: set[str] = set()
        self._work = self._redraw(initial)
        self._map_status_input = self.DeclareAbstractInputPort(
            "map_status", Value(MapStatus(initial))
        )
        self._add_toggles(show_unseen)
        for _ in self._work:
            pass
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, map_status: OutputPort, **arguments
    ) -> "LiveMapView":
        """Adds a view to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            map_status: Output port of the live map's `MapStatus`.
            **arguments: The arguments of `LiveMapView`.
        """
        view = builder.AddSystem(LiveMapView(**arguments))
        builder.Connect(map_status, view.GetInputPort("map_status"))
        return view

    def _add_toggles(self, show_unseen: bool):
        self._page.add_toggle(on_off("Splat", "1", TILES))
        add_unseen_toggle(self._page, shown=show_unseen)

    def _publish(self, context: Context):
        status = self._map_status_input.Eval(context)
        self._page.set_status(status.text, "map", status.trouble)
        if status.scene_map is not self._map:
            self._map = status.scene_map
            self._work = self._redraw(status.scene_map)
        next(self._work, None)

    def _redraw(self, scene_map: SceneMap) -> Iterator[None]:
        """Sends one piece per step; then removes the previous map's pieces."""
        meshcat, kept = self._page.meshcat, set[str]()
        for path in _draw_pieces(meshcat, scene_map):
            if path is not None:
                self._pieces.add(path)
                kept.add(path)
            yield
        for path in self._pieces - kept:
            meshcat.Delete(path)
        self._pieces = kept


def _draw_pieces(meshcat: Meshcat, scene_map: SceneMap) -> Iterator[str | None]:
    """Draws one piece of a map per step; yields its path, or None if empty."""
    for i, tile in enumerate(scene_map.tiles):
        path = f"{TILES}/{i}"
        meshcat.SetTriangleColorMesh(
            path, tile.vertices, tile.faces, tile.colors
        )
        yield path
    coverage = scene_map.coverage
    if coverage is None:
        return
    yield from draw_layers(meshcat, coverage)
