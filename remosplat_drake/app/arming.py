"""`Arming`: lets an operator arm a real robot, at the terminal or over LCM.

A real robot does not move until a person arms it. The person types `arm` at the
program's terminal, or runs `remosplat arm`, which sends a request for this
session. Any other line at the terminal stops the robot. The browser page cannot
arm it, since Meshcat cannot identify its clients.
"""

from pydrake.systems.framework import Context

from remosplat_drake.app.diagram import Application
from remosplat_drake.base.terminal import TerminalLines
from remosplat_drake.hardware.client.robot_link import RobotLink

ARM = "arm"
"""Text that a person types to arm the robot."""

TERMINAL_STOP = "Enter in the terminal"
"""Reason that is displayed after a line other than `arm` at the terminal has
stopped the robot."""

HINT = f"type `{ARM}` and Enter, or call `remosplat {ARM}`; Enter alone stops"
"""Instructions to release the robot, and to stop it."""


class Arming:
    """Passes an operator's requests to the supervisor, between two ticks."""

    def __init__(self, application: Application, link: RobotLink):
        """Connects an application with the link to its robot.

        Args:
            application: The diagram, with its supervisor.
            link: The link to the robot. The link receives requests and sends
                the supervisor's state.
        """
        assert application.supervisor is not None
        self._supervisor = application.supervisor
        self._link = link
        self._terminal = TerminalLines()

    def __call__(self, root: Context) -> None:
        """Processes the requests since the last call.

        Args:
            root: Context of the whole diagram.
        """
        context = self._supervisor.GetMyMutableContextFromRoot(root)
        line = self._terminal.fetch()
        if line is not None and line != ARM:
            self._supervisor.request_stop(context, TERMINAL_STOP)
        if line == ARM or self._link.take_request():
            self._supervisor.request_release(context)
        state = self._supervisor.supervision(context)
        self._link.is_armed |= not state.is_latched
        said = ": ".join(filter(None, [state.reason, state.refusal]))
        self._link.tell(state.mode, said)
