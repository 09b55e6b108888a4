"""Reads a run's state from the context of its diagram."""

from pydrake.systems.framework import Context

from remosplat_drake.app.diagram import Application
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.supervisor_state import SupervisorState


def supervision_of(
    application: Application, root: Context
) -> SupervisorState | None:
    """Reads the supervisor's state; None without a supervisor.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    supervisor = application.supervisor
    if supervisor is None:
        return None
    return supervisor.supervision(supervisor.GetMyContextFromRoot(root))


def selection_of(application: Application, root: Context) -> Selection | None:
    """Reads guidance's selection; None without guidance.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    selector = application.selector
    if selector is None:
        return None
    context = selector.GetMyContextFromRoot(root)
    return selector.GetOutputPort("selection").Eval(context)


def motion_status_of(application: Application, root: Context) -> MotionStatus:
    """Reads the latest description of the robot's state.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    system = application.motion_status
    return system.latest(system.GetMyContextFromRoot(root))


def map_status_of(application: Application, root: Context) -> MapStatus | None:
    """Reads the live map's status; None without a live map.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    live_map = application.live_map
    if live_map is None:
        return None
    return live_map.status(live_map.GetMyContextFromRoot(root))
