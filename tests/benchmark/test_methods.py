"""Methods: the shipped ones, and one's own file beside them."""

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.methods import GROUPS, METHODS_FILE, load_methods
from remosplat_drake.benchmark.paper_results import PAPER_TABLE_I
from remosplat_drake.benchmark.suites import ROBOTS_METHOD
from remosplat_drake.oracle.oracle_config import GroundTruth, SphereToEllipsoid

TOY = """
slow:
  oracle: !GroundTruth {}
  controller: {gains: paper, servo: {max_speed: 0.1}}
fast:
  oracle: !GroundTruth {}
  controller: {gains: paper, servo: {max_speed: 0.6}}
  control_period: 0.02
"""


@pytest.fixture
def toy(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(TOY)
    return path


def test_every_shipped_method_loads():
    methods = load_methods([str(METHODS_FILE)])
    names = [method.name for method in methods]
    assert {x for group in GROUPS.values() for x in group} <= set(names)
    assert len({method.fingerprint for method in methods}) == len(methods)
    others = {*GROUPS["mbm"], *GROUPS["moving"], ROBOTS_METHOD}
    papers = [m for m in methods if m.name not in others]
    assert {m.scenario.control_period for m in papers} == {0.05}
    assert {m.scenario.time_limit for m in papers} == {15.0}


def test_the_variants_differ_in_what_they_are_called_after():
    oracles = {m.name: m.scenario.oracle for m in load_methods(["variants"])}
    assert oracles["sdf-hard-rows"] == GroundTruth(rows="per_primitive")
    assert oracles["ellipsoid-hard-3-steps"] == SphereToEllipsoid(
        bisection_steps=3
    )
    assert oracles["ellipsoid-active-any-opacity"] == SphereToEllipsoid(
        min_opacity=0
    )


def test_motion_problems_are_driven_as_they_were_measured():
    reactive, tuned, guided = load_methods(["mbm"])
    for method in (reactive, tuned, guided):
        assert method.scenario.control_period == 0.02
        assert method.scenario.time_limit == 30
        assert method.scenario.robot.spheres == "paper"
        assert not method.needs_splat
    assert not reactive.scenario.controller.guidance.enabled
    for method in (tuned, guided):
        assert method.scenario.controller.guidance.tiers == [0.010, 0.005]
    assert [x.gains for x in (tuned, guided)] == ["tuned", "fast"]


def test_all_methods_can_drive_another_robot():
    methods = load_methods(["mbm", "sdf-hard"], robot="panda")
    assert {m.scenario.robot.model for m in methods} == {"panda"}
    with pytest.raises(RemoSplatError, match="did you mean 'panda'"):
        load_methods(["sdf-hard"], robot="pando")


def test_shipped_controllers_go_by_short_names():
    (plain, on_splats) = load_methods(["drake-ik", "drake-ik:ellipsoid-hard"])
    assert (plain.name, plain.needs_splat) == ("drake-ik", False)
    assert (on_splats.name, on_splats.needs_splat) == (
        "drake-ik:ellipsoid-hard",
        True,
    )
    with pytest.raises(RemoSplatError, match="did you mean 'drake-ik'"):
        load_methods(["drake-ki"])


def test_the_papers_six_have_its_gains_and_no_safety_net():
    methods = load_methods(["paper"])
    assert [m.name for m in methods] == list(PAPER_TABLE_I)
    for method in methods:
        controller = method.scenario.controller
        assert controller.gains == "paper"
        assert not controller.verify
        assert not controller.guidance.enabled
        assert not method.scenario.supervisor.enabled
        active = method.name.endswith("active")
        assert controller.active_collision.gain == (1.0 if active else 0.0)


def test_variants_of_the_papers_have_none_either():
    assert not any(
        m.scenario.supervisor.enabled for m in load_methods(["variants"])
    )


def test_ours_are_verified_and_supervised():
    for method in load_methods(["ours"]):
        assert method.scenario.controller.verify
        assert method.scenario.supervisor.enabled


def test_ones_own_file_stands_beside_the_shipped_methods(toy):
    methods = load_methods(["sdf-hard", str(toy)], spheres="paper")
    assert [m.name for m in methods] == ["sdf-hard", "slow", "fast"]
    assert [m.scenario.control_period for m in methods] == [0.05, 0.05, 0.02]
    assert {m.scenario.robot.spheres for m in methods} == {"paper"}
    assert methods[1].scenario.controller.servo.max_speed == 0.1
    (only,) = load_methods([f"{toy}:fast"], "{time_limit: 3}")
    assert only.scenario.time_limit == 3.0


def test_settings_change_the_fingerprint_and_names_do_not(toy):
    (a,) = load_methods([f"{toy}:slow"])
    (b,) = load_methods([f"{toy}:slow"], "{control_period: 0.1}")
    assert a.fingerprint != b.fingerprint
    copy = toy.with_name("copy.yaml")
    copy.write_text(TOY)
    (c,) = load_methods([f"{copy}:slow"])
    assert a.fingerprint == c.fingerprint


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["sdf-hart"], "did you mean 'sdf-hard'"),
        (["{toy}:other"], "fast, slow"),
        (["nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_unknown_methods(toy, names, message):
    with pytest.raises(RemoSplatError, match=message):
        load_methods([name.format(toy=toy) for name in names])


def test_what_a_method_must_not_say(tmp_path, toy):
    path = tmp_path / "bad.yaml"
    path.write_text("a: {scene: {truth: x.json}}")
    with pytest.raises(RemoSplatError, match=r"scene\.truth.*benchmark"):
        load_methods([str(path)])
    path.write_text("slow: {}")
    with pytest.raises(RemoSplatError, match="two different methods"):
        load_methods([str(toy), str(path)])
    with pytest.raises(RemoSplatError, match="covering, paper"):
        load_methods(["sdf-hard"], spheres="some")
