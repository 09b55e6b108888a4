"""The controller's side of the fault campaign, as a process.

    python -m remosplat_drake.acceptance.fault_controller URL --fault NAME

It runs a scenario on the robot at an LCM URL, as `remosplat run --hardware`
does. After a stop, it waits for a release. SIGUSR1 begins the fault, a second
SIGUSR1 ends it, and SIGUSR2 releases a stop. Its log on stdout has one JSON
object per line. These are the supervisor's actions, the socket for the buttons
of its page (if it has a page), and the result of the run.
"""

import argparse
import dataclasses as dc
import json
import math
import signal
import time

import numpy as np
from pydrake.systems.framework import Context

from remosplat_drake.app import warm_up
from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.hardware_run import (
    prepare_for_hardware,
    run_on_hardware,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.safety.supervisor_system import STOP_BUTTON
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.visualization.page import MeshcatPage

FAULTS = {
    "stop-button": "a person presses the stop button",
    "exception": "the program fails in the middle of a tick",
    "hang": "the program hangs, and does not end",
    "map-age": "the map no longer receives updates",
    "map-nan": "the map returns NaN",
    "infeasible": "for 1.2 s, the map has a wall on each side of the hand,"
    " both slightly too near: no command satisfies both limits",
}
"""Descriptions of the faults of the controller's process, keyed by name."""

_WRONG = ("exception", "map-nan", "infeasible")
"""Faults in which the map returns wrong results, or none."""

_CONTRADICTION = 1.2
"""The fault `infeasible` lasts for at most this time [s]."""

_TOO_NEAR = 0.002
"""In the fault `infeasible`, the hand's distance from each of the two walls is
less than the stopping distance by this length [m].
"""


class FaultyField(DistanceField):
    """A distance field that returns wrong results during a fault.

    Attributes:
        fault: Name of the present fault from `FAULTS`; empty if there is none.
    """

    def __init__(self, field: DistanceField, sphere: int, distance: float):
        """Wraps a map.

        Args:
            field: The correct field.
            sphere: Index of the sphere that the fault `infeasible` places
                between two walls.
            distance: Distance of that sphere to both walls [m].
        """
        self._field = field
        self._sphere, self._distance = sphere, distance
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz
        self.fault = ""

    @property
    def for_look_ahead(self) -> DistanceField:
        """Returns the correct field, since faults must not affect rollouts."""
        return self._field.for_look_ahead

    @property
    def compiled(self) -> Packed | None:
        """The correct field's compiled form; None if results are wrong."""
        return None if self.fault in _WRONG else self._field.compiled

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Returns the correct clearances, changed by the present fault."""
        if self.fault == "exception":
            raise RuntimeError("the map has failed: injected fault")
        if self.fault == "map-nan":
            return Clearances.unknown(len(spheres))
        answer = self._field.clearances(spheres, max_distance)
        if self.fault != "infeasible" or len(spheres) <= self._sphere:
            return answer
        x = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
        reach = self._distance + spheres.radius[self._sphere]
        return Clearances(
            np.append(answer.sphere, [self._sphere] * 2),
            np.append(answer.distance, [self._distance] * 2),
            np.vstack([answer.direction_W, x]),
            np.vstack([answer.p_WC, spheres.p_WS[self._sphere] + reach * x]),
            answer.revision,
        )


class FaultInjector:
    """Begins a fault at SIGUSR1, and ends it at the next SIGUSR1."""

    def __init__(self, application: Application, field: FaultyField, name: str):
        """Installs the handlers of the signals.

        Args:
            application: The application, whose map is `field`.
            field: The field that the fault changes.
            name: Name of the fault, from `FAULTS`.
        """
        assert application.supervisor is not None
        self._supervisor = application.supervisor
        self._field, self._name = field, name
        self._since = math.inf
        self._release = False
        self._refusal = ""
        signal.signal(signal.SIGUSR1, self._switch)
        signal.signal(signal.SIGUSR2, self._ask_for_release)

    def _switch(self, *_) -> None:
        self._since = time.time() if math.isinf(self._since) else math.inf

    def _ask_for_release(self, *_) -> None:
        self._release = True

    def __call__(self, root: Context) -> None:
        """Applies the requests of the signals, between two control ticks."""
        context = self._supervisor.GetMyMutableContextFromRoot(root)
        self._release_if_asked(context)
        lasted = time.time() - self._since
        if self._name == "map-age":
            port = self._supervisor.GetInputPort("map_age")
            port.FixValue(context, [max(lasted, 0.0)])
        self._field.fault = ""
        if lasted < 0:
            return
        if self._name == "stop-button":
            self._since = math.inf
            self._supervisor.request_stop(context, STOP_BUTTON)
        elif self._name == "hang":
            signal.pause()
        elif self._name != "infeasible" or lasted <= _CONTRADICTION:
            self._field.fault = self._name

    def _release_if_asked(self, context: Context) -> None:
        """Requests a release if a signal came; logs the reason of a refusal."""
        refusal = self._supervisor.supervision(context).refusal
        if refusal and refusal != self._refusal:
            _log(refusal=refusal)
        self._refusal = refusal
        if self._release:
            self._release = False
            self._supervisor.request_release(context)


def main() -> None:
    """Runs the scenario until the target is reached or a signal ends it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("--fault", default="", choices=["", *FAULTS])
    parser.add_argument("--scenario")
    parser.add_argument("--scenario-text", default="")
    parser.add_argument("--page", action="store_true")
    arguments = parser.parse_args()
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    prepare_for_hardware(scenario, arguments.url)
    world = load_world(scenario)
    spheres = world.robot.spheres_at(world.q0)
    field = FaultyField(
        world.field,
        len(spheres) - 1,
        scenario.controller.collision.stopping - _TOO_NEAR,
    )
    warm_up.compile_kernels(scenario, world)
    world = dc.replace(world, field=field)
    if arguments.fault in _WRONG:
        field.fault = arguments.fault
        warm_up.compile_kernels(scenario, world)
        field.fault = ""
    page = MeshcatPage() if arguments.page else None
    if page is not None:
        _log(socket=page.meshcat.ws_url())
    application = build(scenario, world, page, hardware=True)
    injector = FaultInjector(application, field, arguments.fault)
    result = run_on_hardware(
        application,
        on_supervision=_log_supervision,
        between_ticks=injector,
        patience=math.inf,
    )
    _log(
        outcome=result.run.outcome,
        statuses=result.run.metrics.statuses,
        loop=dc.asdict(result.loop),
    )


def _log_supervision(supervision: SupervisorState) -> None:
    _log(mode=supervision.mode, reason=supervision.reason)


def _log(**values) -> None:
    print(json.dumps({"time": time.time(), **values}), flush=True)


if __name__ == "__main__":
    main()
