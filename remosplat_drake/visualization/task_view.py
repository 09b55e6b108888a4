"""`TaskView`: lists the steps of a task and its objects on the page."""

from pydrake.common.value import Value
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.signals.task_outline import TaskOutline
from remosplat_drake.visualization.object_view import OBJECTS
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD


class TaskView(LeafSystem):
    """Lists the steps and the objects of a task, and marks the present step.

    .. pydrake_system::

        name: TaskView
        input_ports:
        - outline

    `outline` takes the `TaskOutline`.

    Args:
        page: The page that lists them.
    """

    def __init__(self, *, page: MeshcatPage):
        super().__init__()
        self.set_name("task_view")
        self._page = page
        self._shown = TaskOutline()
        self._outline_input = self.DeclareAbstractInputPort(
            "outline", Value(self._shown)
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage
    ) -> "TaskView":
        """Adds a view to a diagram; the caller connects its port."""
        return builder.AddSystem(TaskView(page=page))

    def _publish(self, context: Context):
        outline = self._outline_input.Eval(context)
        if outline != self._shown:
            self._shown = outline
            self._page.set_task(outline, OBJECTS)
