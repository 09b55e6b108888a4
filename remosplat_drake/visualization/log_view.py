"""`LogView`: tells the operator when the log of the run lacks something."""

from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.visualization.page import MeshcatPage

_PERIOD = 0.25
"""Time between two looks [s]."""


class LogView(LeafSystem):
    """Shows a log's trouble as a line of text among the controls.

    .. pydrake_system::

        name: LogView
        input_ports:
        - trouble

    Args:
        page: Where to show it.
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
        """Adds a view and connects it to a log."""
        view = builder.AddSystem(LogView(page=page))
        builder.Connect(trouble, view.GetInputPort("trouble"))
        return view

    def _publish(self, context: Context):
        self._page.set_status(self._trouble_input.Eval(context), "log")
