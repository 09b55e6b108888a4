"""A parcel on its way from the movers to the map, through five processes.

A robot, its wrist camera, a camera in the room, `remosplat detect`, and a
teleoperation whose map grows.
"""

import contextlib
import time

import numpy as np
import pytest
from handover import who_knows
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.hardware_processes import (
    free_url,
    program,
    robot,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.counting import decode_counting
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.movers import decode_movers
from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.mapping.store.session import Session

PLACE, HALF = np.array([0.95, 0.42, 0.65]), np.array([0.06, 0.06, 0.05])
TABLE = "package://remosplat_drake/models/scenes/table"
SCENARIO = f"""
Parcel:
  scene: {{splat: {TABLE}/splat.ply, truth: {TABLE}/scene.json, unknown: free}}
  control_period: 0.02
  teleop:
    workspace_lower: [-1.0, -1.5, 0.1]
    workspace_upper: [2.0, 1.5, 1.8]
  wrist_camera: {{width: 160, height: 120}}
  hardware: {{movers: {{}}}}
  cameras:
  - name: room
    translation: [-0.3, 1.0, 1.9]
    look_at: {PLACE.tolist()}
    width: 160
    height: 120
  movers:
  - name: parcel
    half_extents: {HALF.tolist()}
    radius: 0.001
    waypoints:
    - {{time: 5, translation: [0.95, 1.8, 0.9]}}
    - {{time: 7, translation: {PLACE.tolist()}}}
"""
SCRIPT = """
steps:
- {time: 1, translation: [0.75, 0.42, 0.95], rpy_deg: [180, -25, 0]}
"""
TELEOP = ["--hardware", "--without-doctor", "--headless"]


class Listener:
    """Hears what moves and which map counts, and lets the robot go."""

    def __init__(self, url: str, session, field):
        self.consent = Consent(url, again=True)
        self.wanted = [channels.MOVERS, channels.COUNTING_MAP]
        self.inbox = Inbox(DrakeLcm(url), self.wanted)
        self.session, self.field = session, field
        self.version, self.movers = 0, None

    def listen(self) -> None:
        for channel, data in self.inbox.fetch(0.02):
            if channel == channels.MOVERS:
                self.movers = decode_movers(data)
            else:
                self.hear(decode_counting(data, time.time()).version)
        if self.movers is not None:  # All that shall see it come is there.
            self.consent.give()

    def hear(self, version: int) -> None:
        if version > self.version:
            path = Session.open(self.session).map_path(version)
            self.version, self.field = version, open_map(path).field


@pytest.mark.slow
def test_a_parcel_is_in_the_map_before_it_leaves_the_movers(tmp_path):
    scenario, script = tmp_path / "parcel.yaml", tmp_path / "script.yaml"
    scenario.write_text(SCENARIO)
    script.write_text(SCRIPT)
    spec, session, url = str(scenario), tmp_path / "session", free_url()
    field = load_world(load_scenario(spec)).field
    flags = ["--trajectory", str(script), "--session", str(session)]
    with contextlib.ExitStack() as at:

        def start(command: str, *arguments: str):
            line = [command, spec, *arguments, "--lcm-url", url]
            return at.enter_context(program(*line))

        at.enter_context(robot(url, spec))
        teleop = start("teleop", *TELEOP, *flags)
        end = time.monotonic() + PATIENCE
        while not (session / "session.json").exists():
            assert teleop.poll() is None and time.monotonic() < end
            time.sleep(0.1)
        start("camera-sim", "--rate", "2")
        start("camera-sim", "--camera", "room", "--rate", "15")
        start("detect", "--session", str(session))
        listener, story = Listener(url, session, field), []
        while story[-1:] != [{"map"}]:
            assert teleop.poll() is None and time.monotonic() < end, story
            listener.listen()
            known = who_knows(
                PLACE, HALF, listener.field, listener.movers or []
            )
            if known not in story[-1:]:
                story.append(known)
    # While it comes, an enclosure may still be beside the place.
    after = story[story.index({"movers"}) :] if {"movers"} in story else []
    assert after[-3:] == [{"movers"}, {"movers", "map"}, {"map"}], story
    assert set() not in after[-3:]
    assert listener.version >= 1
