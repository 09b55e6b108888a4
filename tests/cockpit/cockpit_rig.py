"""A cockpit without a control loop: a test tells it how things stand."""

import dataclasses as dc
import time
from collections.abc import Callable

import numpy as np
from patience import PATIENCE

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.messages import (
    CockpitJob,
    CodeIssued,
    MapPicture,
    PageContent,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.visualization.page_state import (
    LIVE,
    RELEASE,
    STOP,
    STOPPED,
    PageState,
)

RUNNING = PageState(LIVE, "Live", "moving to target 1 of 1", (STOP,))
AT_REST = PageState(STOPPED, "Stopped", "stop button", (STOP, RELEASE))


_FIELDS = [f for f in dc.fields(PageContent) if f.name != "time"]


class Rig:
    """A cockpit of a shipped scenario."""

    def __init__(
        self,
        name: str = "TableTeleop",
        host: str = "127.0.0.1",
        thin: int = 50,
        port: int | None = None,
        solids: bool = False,
    ):
        self.scenario = scenario = load_scenario(name)
        self.world = world = load_world(scenario, blank=True)
        law = ReactiveLaw.make(
            scenario.controller, world.robot, scenario.control_period
        )
        self.codes: list[CodeIssued] = []
        self.process = CockpitProcess(self.codes.append)
        self.job = CockpitJob(
            title=name,
            host=host,
            port=port,
            robot=world.robot,
            planner=MotionPlanner(
                world.robot,
                law.self_clearance,
                scenario.controller.guidance.planning,
            ),
            stopping=scenario.controller.collision.stopping,
            influence=scenario.controller.collision.influence,
            control_period=scenario.control_period,
            config=scenario.teleop,
            q0=world.q0,
            mapping=True,
            scenes=(world.truth, world.truth),
            X_EC=np.eye(4),
            truth=world.truth if solids else None,
        )
        # In software pictures of more take seconds.
        few = np.arange(len(world.splat_W)) % thin == 0
        splat_W = None if solids else world.splat_W.select(few)
        self.picture = MapPicture(world.field, splat_W, None, False)
        self.url = self.process.start(self.job, self.picture)
        state = world.robot.state(world.q0)
        self.content = PageContent(
            0.0, world.q0, state.X_WE, state.X_WB, state.X_WE, state=RUNNING
        )
        self._first = self.content
        self._used = 0
        self.process.show(self.content)
        self.until(lambda: self.codes)

    def begin(self):
        """Tells the cockpit that all is as at the start."""
        self.show(**{f.name: getattr(self._first, f.name) for f in _FIELDS})

    def wait_until_left(self):
        """Waits until a code is issued, if the last one was used."""
        self.until(lambda: len(self.codes) > self._used)

    @property
    def code(self) -> str:
        """The code that was issued last, for a client that will operate."""
        self._used = len(self.codes)
        return self.codes[-1].code

    @property
    def requests(self):
        """All that people have asked for."""
        return self.process.requests

    def show(self, **changes):
        """Tells the cockpit of another moment."""
        self.content = dc.replace(self.content, **changes)
        self.process.show(self.content)

    def follow(self):
        """Lets the target be where the cockpit has put it."""
        X_WT = self.requests.command.X_WT
        assert X_WT is not None
        self.show(X_WT=np.array(X_WT), is_followed=True)

    def until(self, condition: Callable[[], object]):
        """Waits until something is so."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, self.requests
            time.sleep(0.02)
