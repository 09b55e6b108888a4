"""`CockpitOperator`: outputs the requests of the cockpit's operator."""

import dataclasses as dc
from collections.abc import Sequence

from pydrake.common.value import Value
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.messages import CockpitRequests
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests, scene_in_turn
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.teleop.gamepad import SILENCE


class CockpitOperator(LeafSystem):
    """Outputs the requests of the people at the cockpit.

    .. pydrake_system::

        name: CockpitOperator
        output_ports:
        - command
        - map_requests
        - operator

    `command` carries the `OperatorCommand`, `map_requests` the `MapRequests`
    and `operator` the `OperatorRequests` so far. They come from the latest
    message of the cockpit's process. If this process sends no messages, its
    STOP does not work, and `operator` reports that.

    Args:
        process: The process that serves the cockpit's page.
        scenes: The scenes that a simulated camera can show. It shows the first
            scene at the start; each press of a button switches to the next
            scene.
    """

    def __init__(
        self, *, process: CockpitProcess, scenes: Sequence[PrimitiveScene] = ()
    ):
        super().__init__()
        self.set_name("cockpit_operator")
        self._process = process
        self._scenes = tuple(scenes)
        for name, value, calc in (
            ("command", OperatorCommand(), self._calc_command),
            ("map_requests", MapRequests(), self._calc_map_requests),
            ("operator", OperatorRequests(), self._calc_operator),
        ):
            self.DeclareAbstractOutputPort(
                name, Value(value).Clone, calc, {self.time_ticket()}
            )

    def _calc_command(self, context: Context, output: Value):
        process = self._process
        output.set_value(command_now(process.requests, process.silence))

    def _calc_map_requests(self, context: Context, output: Value):
        output.set_value(map_requests(self._process.requests, self._scenes))

    def _calc_operator(self, context: Context, output: Value):
        requests, trouble = self._process.requests, self._process.trouble
        output.set_value(dc.replace(requests.operator, trouble=trouble))


def command_now(requests: CockpitRequests, silence: float) -> OperatorCommand:
    """Returns the command for the target.

    Args:
        requests: All requests so far.
        silence: Time since the last message of the cockpit's process [s]. After
            `SILENCE` a dead-man switch counts as released.
    """
    if silence > SILENCE:
        return dc.replace(requests.command, V_W=None)
    return requests.command


def map_requests(
    requests: CockpitRequests, scenes: Sequence[PrimitiveScene]
) -> MapRequests:
    """Returns the requests to the map.

    Args:
        requests: All requests so far.
        scenes: The scenes that a simulated camera can show; it shows the first
            scene at the start.
    """
    scene = scene_in_turn(scenes, requests.scene_changes)
    return dc.replace(requests.map_requests, scene=scene)
