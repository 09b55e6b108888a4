"""Random operators: what they do, and how the truth judges them."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from apps.studies.operators import campaign
from apps.studies.operators.__main__ import table
from apps.studies.operators.campaign import OperatorTrial
from apps.studies.operators.mapped_truth import MappedTruth
from apps.studies.operators.random_operator import Look, RandomOperator
from apps.studies.operators.result import (
    MAPPED,
    SCENE,
    UNSEEN,
    OperatorResult,
    Touch,
    read_results,
    to_line,
)
from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

SIZE = 12, 16
CHANGED = 2.0


def box(z: float) -> Box:
    """A wall whose face is at z, across the view of a camera at W's origin."""
    return Box(RigidTransform([0, 0, z + 0.05]), np.array([1, 1, 0.05]))


WALL = PrimitiveScene((box(1.0),), name="wall")
BLOCKED = PrimitiveScene((box(1.0), box(0.5)), name="something before it")


@pytest.fixture
def truth(tmp_path) -> MappedTruth:
    """A wall; something comes at 2 s, is seen at 3 s, and goes at 4 s.

    Map 1 has only the first frame.
    """
    session = Session.create(tmp_path / "session", "")
    for number, (time, z) in enumerate([(1.0, 1.0), (3.0, 0.5)], 1):
        frame = Frame(
            name="the frame",
            K=np.array([[20.0, 0, 8], [0, 20, 6], [0, 0, 1]]),
            X_WC=np.eye(4),
            rgb=np.zeros((*SIZE, 3), np.uint8),
            depth=np.full(SIZE, z, np.float32),
            time=time,
        )
        session.activate(session.frames.add(frame, np.zeros(10)))
        version = Version(number, number - 1, "", session.active, 1.0)
        session.record(version, set())
    return MappedTruth(session, (WALL, BLOCKED), (CHANGED, 4.0), max_depth=3.0)


def clearance(field, z: float) -> float:
    return field.clearances(Spheres.at(np.array([0, 0, z]), 0.02)).minimum()


def test_what_was_measured_and_is_still_there_is_mapped(truth):
    assert clearance(truth.surfaces(1, 0), 0.9) == pytest.approx(0.08, abs=0.01)
    # The wall has stayed; what came is in the second map only.
    assert clearance(truth.surfaces(1, 1), 0.9) == pytest.approx(0.08, abs=0.01)
    assert clearance(truth.surfaces(1, 1), 0.4) > 0.5
    assert clearance(truth.surfaces(2, 1), 0.4) == pytest.approx(0.08, abs=0.01)
    # And it counts no more once it has gone.
    assert clearance(truth.surfaces(2, 2), 0.4) > 0.5
    # Nothing is mapped without a map.
    assert clearance(truth.surfaces(0, 0), 0.9) == np.inf


def test_what_came_is_known_once_a_frame_shows_it(truth):
    assert truth.changes_before(1.9) == 0
    assert truth.changes_before(CHANGED) == 1
    assert len(truth.known(1, 1)) == 1
    assert len(truth.known(2, 1)) == 2
    assert len(truth.known(2, 2)) == 1


class Person:
    """A random operator who looks at a robot far from everything."""

    def __init__(self, seed: int):
        self.operator = RandomOperator(seed, ["left"], (WALL, BLOCKED))
        self.time = 0.0
        self.now = Look(0.0, 0.0, False, None, Spheres.at(np.zeros(3), 0.1))

    def watch(self, duration: float, **changes) -> None:
        self.now = dc.replace(self.now, **changes)
        for _ in range(round(duration / 0.1)):
            self.time += 0.1
            self.operator.look(dc.replace(self.now, time=self.time))


def test_an_operator_watches_the_first_scan_and_then_wants_anything():
    person = Person(3)
    person.watch(20.0)
    assert person.operator.command.scans == 1
    assert person.operator.command.moves == 0
    person.watch(600.0, parent=1)
    command, requests = person.operator.command, person.operator.map_requests
    for name in ("moves", "poses", "holds", "homes", "scans"):
        assert getattr(command, name) > 1
    for name in ("frames", "refines", "undos"):
        assert getattr(requests, name) > 0
    assert requests.scene is not None


def test_a_helpless_operator_tries_another_frame_or_another_map():
    person = Person(0)
    person.watch(1.0)
    person.watch(3.0, parent=1, stopped=3.0)
    assert person.operator.map_requests.frames == 0
    for seconds in range(3, 40):
        person.watch(1.0, stopped=float(seconds))
    requests = person.operator.map_requests
    assert requests.frames > 0
    assert requests.undos > 0
    assert person.operator.command.moves == 0


def test_equal_seeds_want_the_same():
    one, same, other = Person(5), Person(5), Person(6)
    for person in (one, same, other):
        person.watch(60.0, parent=1)
    assert one.operator.map_requests == same.operator.map_requests
    np.testing.assert_array_equal(
        one.operator.command.X_WT, same.operator.command.X_WT
    )
    assert one.operator.command.moves == same.operator.command.moves
    assert not np.array_equal(
        one.operator.command.X_WT, other.operator.command.X_WT
    )


def test_no_operator_puts_a_thing_into_a_robot():
    person = Person(3)
    person.watch(1.0)
    spheres = Spheres.at(np.array([0, 0, 0.55]), 0.1)
    person.watch(900.0, parent=1, spheres=spheres)
    assert person.operator.map_requests.scene is None


def touch(what: str) -> Touch:
    return Touch(what, 1.0, 0.5, 0.01, "panda_hand", (1.0, 0.0, 0.5), 2)


def test_results_are_kept_and_collisions_counted(tmp_path):
    touches = (touch(MAPPED), touch(SCENE), touch(UNSEEN))
    free = OperatorResult("a", "StudioFree", 0, touches=touches)
    careful = dc.replace(free, key="b", careful=True)
    assert (free.collisions, careful.collisions) == (1, 2)
    path = tmp_path / "results.jsonl"
    failed = campaign.crashed(OperatorTrial("c", 1, 60.0, ""), "it broke")
    lines = [to_line(r) for r in (free, careful, failed)]
    path.write_text("\n".join(lines) + "\n{cut off")
    assert read_results(path) == {"a": free, "b": careful}
    assert table([free, careful, failed]).row_count == 3
    path.write_text("nonsense\n")
    with pytest.raises(FileError, match="not JSON"):
        read_results(path)
    assert read_results(tmp_path / "none") == {}


def test_they_take_turns():
    trials = campaign.make_trials(3, 0.5, 7, campaign.Path("out"))
    assert [t.scenario for t in trials] == [
        "StudioFree",
        "StudioLive",
        "StudioFree",
    ]
    assert [(t.seed, t.duration) for t in trials] == [
        (7, 30.0),
        (8, 30.0),
        (9, 30.0),
    ]


@pytest.mark.slow
@pytest.mark.usefixtures("rendering")
def test_an_operator_touches_nothing_that_was_mapped(tmp_path):
    trial = OperatorTrial(
        "StudioFree",
        0,
        20.0,
        str(tmp_path / "operator"),
        "{mapping: {frames: 3, latency: 1.0}}",
    )
    result = campaign.run_operator(trial)
    assert result.ticks == 2000
    assert result.maps >= 1
    assert result.path_length > 0.1
    assert result.collisions == 0
    assert result.mapped_clearance > 0
