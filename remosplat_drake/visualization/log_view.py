"""`LogView`: reports on the page when the log of a run is incomplete."""

from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.visualization.page import MeshcatPage

_PERIOD = 0.25
"""Time between two updates [s]."""


class LogView(LeafSystem):
    """Shows the problem of a `TrajectoryLog` as a line of text.

    .. pydrake_system::

        name: LogView
        input_ports:
        - trouble

    Args:
        page: The page that shows the line.
    """

    def __init__(self, *, page: MeshcatPage):
        super().__init__()
        self.set_name("log_view")
        self._page = page
        self._trouble_input = self.DeclareAbstractInputPort(
            "trouble", Value("")
        )
        self.DeclarePeriodicPublishEvent(_PERIOD, 0.0, self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage, trouble: OutputPort
    ) -> "LogView":
        """Adds a view to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            page: The page that shows the line.
            trouble: Output port `trouble` of a `TrajectoryLog`.
        """
        view = builder.AddSystem(LogView(page=page))
        builder.Connect(trouble, view.GetInputPort("trouble"))
        return view

    def _publish(self, context: Context):
        self._page.set_status(self._trouble_input.Eval(context), "log")
