"""An operator points at a thing in the map, and it becomes an object."""

import time
from functools import partial

import numpy as np
import pytest
from found_scene import CAN, HEIGHT, ON_IT, RADIUS, TOP, write_found_scene
from job_rig import JobRig
from patience import PATIENCE

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.stages.task import job_maker
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Cylinder
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.job_process import JobProcess
from remosplat_drake.task.task import DONE, FAILED, TaskState


def room(rig: JobRig, p_W: np.ndarray) -> float:
    """Distance of a point from the map that the robot uses [m]."""
    targets = rig.application.targets
    field = targets.GetOutputPort("distance_field").Eval(rig._mine(targets))
    return field.clearances(Spheres.at(p_W)).minimum()


def test_a_can_of_the_map_is_taken_and_put_on_the_tray(tmp_path):
    """In one run, since it says what happens from job to job."""
    rig = JobRig(tmp_path / "session", write_found_scene(tmp_path))
    refuses_what_is_no_object(rig)
    finds_the_can(rig)
    refuses_the_same_again(rig)
    takes_and_places_it(rig)


def refuses_what_is_no_object(rig):
    for p_W, reason in (
        ([1.3, 0.0, TOP], "the map has no Gaussian within 0.05 m"),
        ([1.3, 0.0, 0.4958], "no level surface within 0.4 m below"),
    ):
        rig.ask("finds", p_WFind=np.array(p_W))
        rig.until_idle()
        assert rig.jobs.state.outcome == FAILED
        assert reason in rig.led.text
    assert len(rig.p_WO) == 2


def finds_the_can(rig):
    before = rig.X_WE
    rig.ask("finds", p_WFind=ON_IT)
    rig.until_idle()
    assert rig.led.text.startswith(
        "hold: find an object: object 1 is a cylinder of 6"
    )
    assert rig.led.text.endswith(" mm, 0.35 kg assumed: done")
    thing = rig.jobs.state.named("object 1")
    assert isinstance(thing.solid, Cylinder) and thing.mass == 0.35
    assert 0.0 < thing.solid.radius - RADIUS < 0.0015
    np.testing.assert_allclose(thing.X_WO.translation(), CAN, atol=0.001)
    np.testing.assert_allclose(rig.X_WE, before, atol=1e-4)
    # In the map, its shape is in place of its Gaussians.
    assert room(rig, CAN) == pytest.approx(-thing.solid.radius, abs=1e-6)
    scene = rig.jobs.scene
    alone = scene.field.clearances(Spheres.at(CAN)).minimum()
    assert alone > 0.5 * HEIGHT - 0.009
    p_W = np.array(rig.world.scene_splat_W.p_GK, float)
    gone = len(p_W) - len(scene.splat_W)
    on_can = np.linalg.norm(p_W[:, :2] - CAN[:2], axis=1) < RADIUS + 0.001
    assert gone == np.count_nonzero(on_can & (p_W[:, 2] > TOP + 0.008))
    # All else is as before.
    beside = np.add(CAN, [0.0, 0.0, -0.5 * HEIGHT - 0.03])
    beside[1] += 0.1
    assert room(rig, beside) < 0.031


def refuses_the_same_again(rig):
    rig.ask("finds", p_WFind=ON_IT)
    rig.until_idle()
    assert rig.jobs.state.outcome == FAILED and len(rig.p_WO) == 3


def takes_and_places_it(rig):
    rig.ask("takes", thing="object 1")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    assert rig.jobs.state.held == "object 1"
    # Its old place is free.
    assert room(rig, CAN) > 0.04
    rig.ask("places", support="tray")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    p_WO = rig.p_WO["object 1"]
    assert abs(p_WO[0] - 1.14) < 0.12 and abs(p_WO[1] - 0.8) < 0.15
    assert p_WO[2] == pytest.approx(TOP + 0.04 + 0.5 * HEIGHT, abs=0.006)
    assert room(rig, p_WO) < -0.03 and room(rig, CAN) > 0.04


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return write_found_scene(tmp_path_factory.mktemp("found"))


def make_maker(name: str, text: str = "{}") -> JobMaker:
    scenario = load_scenario(name, text)
    world = load_world(scenario, blank=True)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    return job_maker(scenario, world, law, hardware=False)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{mapping: {enabled: true}}", "set mapping.enabled to false"),
        ("{oracle: !GroundTruth {}}", "measures no distances to the splat"),
        ("{station: !DynamicStation {}}", "the dynamic station has no body"),
    ],
)
def test_where_it_could_not_be_taken_nothing_is_found(scene, text, reason):
    maker = make_maker(scene, text)
    with pytest.raises(RemoSplatError, match=reason) as error:
        maker.find(ON_IT, None, TaskState(()))
    assert "add it to the scenario's `objects`" in str(error.value)


def test_a_process_finds_the_same(scene, tmp_path):
    scenario = load_scenario(scene)
    world = load_world(scenario)
    session = open_teleoperation(scenario, world, tmp_path / "s", hardware=True)
    static, maker = session.static_map, make_maker(scene)

    asked = partial(
        JobMaker.find, near=ON_IT, scene=static, state=TaskState(world.objects)
    )
    assert static is not None
    here = asked(maker)
    process = JobProcess(maker)
    process.start()
    end = time.monotonic() + PATIENCE
    while (found := process(asked, static.field)) is None:
        assert time.monotonic() < end
        time.sleep(0.05)
    process.close()
    assert found.problem == "" and found.new is not None
    assert found.new.thing.name == here.thing.name == "object 1"
    p_WO = here.thing.X_WO.translation()
    np.testing.assert_array_equal(found.new.thing.X_WO.translation(), p_WO)
    assert found.new.scene.field.revision == here.scene.field.revision
    # Kernels would be compiled again for arrays that can be written.
    splat_W = found.new.scene.splat_W
    assert splat_W is not None and not splat_W.p_GK.flags.writeable
