"""A scenario on the robot, which is a process of its own behind the wire."""

import gc
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import lcm
import numpy as np
import pytest
from consenting import consenting
from drake import lcmt_panda_command
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, robot_process
from runs import PATIENT, command_line, complaint, remosplat

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app import warm_up
from remosplat_drake.app.diagram import build
from remosplat_drake.app.hardware_limits import (
    NARROWER,
    REQUIRED,
    check_for_hardware,
)
from remosplat_drake.app.hardware_run import (
    HardwareLoop,
    bring_to_rest,
    prepare_for_hardware,
    run_on_hardware,
)
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.doctor.doctor_report import (
    DoctorReport,
    needed_checks,
    this_host,
)
from remosplat_drake.hardware.doctor.drills import DRILLS
from remosplat_drake.hardware.doctor.finding import PASSED, SKIPPED, Finding
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    GroundTruth,
    SphereToEllipsoid,
)
from remosplat_drake.recording.trajectory import load_trajectory
from remosplat_drake.robot.braking import braking_steps
from remosplat_drake.signals.supervisor_state import STOPPED
from remosplat_drake.signals.tick_report import TickReport

STILL = 1e-3  # [rad/s]
END = "END"  # The channel of a message that comes after all commands.


def make_application(url: str, follow_dwell: float = 2.0, **hardware: float):
    scenario = load_scenario("TableReach", f"time_limit: 60{PATIENT}")
    scenario.supervisor.follow_dwell = follow_dwell
    for name, value in hardware.items():
        setattr(scenario.hardware, name, value)
    prepare_for_hardware(scenario, url)
    world = load_world(scenario)
    warm_up.compile_kernels(scenario, world)
    return build(scenario, world, hardware=True)


@pytest.fixture
def robot(lone_robot) -> Iterator[tuple[str, Client]]:
    """The wire to a robot at the start of the scenario, and a listener."""
    url = free_url()
    with robot_process(url, "TableReach"), consenting(url):
        client = Client(url)
        client.wait_for_robot()
        yield url, client


def moves(client: Client) -> bool:
    return bool(np.abs(client.latest.joint_velocity).max() > 0.05)


def assert_stays_still(client: Client) -> None:
    """From now on, without a controller that commands it."""
    client.listen_for(0.2)
    q = np.array(client.latest.joint_position)
    pose = np.array(client.latest_base.pose)
    client.listen_for(0.3)
    assert np.abs(client.latest.joint_velocity).max() < STILL
    np.testing.assert_allclose(client.latest.joint_position, q, atol=1e-4)
    np.testing.assert_allclose(client.latest_base.pose, pose, atol=1e-4)


@contextmanager
def commands_heard(url: str) -> Iterator[list[np.ndarray]]:
    """Everything that is commanded in the meantime, each of shape (9,)."""
    wire = lcm.LCM(url)
    heard: list[np.ndarray] = []
    ended, arm = threading.Event(), np.zeros(7)

    def hear_arm(_, data: bytes) -> None:
        arm[:] = lcmt_panda_command.decode(data).joint_velocity

    def hear_base(_, data: bytes) -> None:
        base = base_command.decode(data)
        heard.append(np.array([base.forward, base.yaw_rate, *arm]))

    # Unlike Drake's, these subscriptions drop nothing.
    for channel, handler in (
        (channels.PANDA_COMMAND, hear_arm),
        (channels.BASE_COMMAND, hear_base),
        (END, lambda *_: ended.set()),
    ):
        wire.subscribe(channel, handler).set_queue_capacity(0)

    def listen():
        while not ended.is_set():
            wire.handle_timeout(100)

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        yield heard
    finally:
        end = DrakeLcm(url)
        while thread.is_alive():
            end.Publish(END, b"")
            thread.join(0.1)


def test_coming_to_rest_is_a_straight_ramp_and_zeros(frankie):
    url, period = free_url(), 0.02
    link = RobotLink(HardwareConfig(lcm_url=url), frankie)
    u = np.array([0.2, -0.3, 0.5, 0, 0, 0, 0, 0, -1.0])
    limit = frankie.acceleration_limit
    with commands_heard(url) as heard:
        link.send(u)
        bring_to_rest(link, limit, period)
    ramp = np.array(heard)
    np.testing.assert_allclose(ramp[0], u)
    moving = ramp[np.abs(ramp).max(axis=1) > 1e-12]
    # Steps that a busy machine leaves out are made up for.
    steps = braking_steps(u, limit, period)
    assert len(moving) <= steps + 1e-9
    share = -np.diff(ramp[:, 0])[: len(moving) - 1] / u[0]
    np.testing.assert_allclose(share * steps, np.round(share * steps))
    np.testing.assert_allclose(
        moving, np.outer(moving[:, 0] / u[0], u), atol=1e-12
    )
    assert not ramp[-4:].any()
    assert not link.u.any()


def test_only_a_real_robot_is_taken_to_be_late():
    scenario = load_scenario("TableReach")
    simulated = build(scenario)
    real = make_application(free_url())
    assert not simulated.diagram.HasSubsystemNamed("predictor")
    assert real.diagram.HasSubsystemNamed("predictor")


def test_a_rehearsal_sends_nothing(robot):
    url, _ = robot
    with commands_heard(url) as heard:
        loop = HardwareLoop(make_application(url))
        loop.rehearse()
        assert not heard
        loop.start()
    assert heard
    assert not np.any(heard)


@pytest.mark.slow
def test_a_long_run_does_not_keep_its_reports(robot):
    """A robot that waits for hours must not fill the memory."""
    url, _ = robot
    loop = HardwareLoop(make_application(url))
    loop.start()
    alive = []
    for _ in range(3):
        for _ in range(30):
            loop.tick()
        gc.collect()
        found = [isinstance(o, TickReport) for o in gc.get_objects()]
        alive.append(sum(found))
    assert max(alive) - min(alive) < 10


@pytest.mark.slow
def test_a_shadow_computes_everything_and_sends_nothing(robot, tmp_path):
    url, client = robot
    with commands_heard(url) as heard:
        ran = remosplat(
            *("run", "TableReach", "--hardware", "--shadow", "--headless"),
            *("--lcm-url", url, "--output", tmp_path),
            *("--scenario-text", f"time_limit: 2{PATIENT}"),
        )
        assert_stays_still(client)
    assert not heard
    said = " ".join(ran.stdout.split())
    assert "time limit: robot is commanded to move and stands still" in said
    written = load_trajectory(tmp_path / "trajectory.npz")
    # It would have driven: each tick begins at rest, where the robot is.
    assert np.abs(written.u).max() > 0
    assert np.ptp(written.q, axis=0).max() < 1e-4


@pytest.mark.slow
def test_the_table_scenario_reaches_its_target_through_the_wire(robot):
    url, client = robot
    done = run_on_hardware(make_application(url))
    assert done.run.outcome == REACHED
    assert done.run.metrics.truth_clearance_min > 0
    assert done.loop.ticks == len(done.run.trajectory)
    assert_stays_still(client)


@pytest.mark.slow
def test_a_slower_base_gets_there_at_its_own_speed(robot):
    url, client = robot
    application = make_application(
        url, follow_dwell=0.5, base_forward_upper=0.03, base_yaw_rate=0.3
    )
    with commands_heard(url) as heard:
        done = run_on_hardware(application)
    assert done.run.outcome == REACHED, done.run
    forward, yaw_rate = np.array(heard)[:, :2].T
    # As fast as it may go, so that the bound has been met.
    assert 0.0299 < forward.max() < 0.03004
    assert np.abs(yaw_rate).max() < 0.3003
    driven = np.array([status.forward for status in client.base])
    assert driven.max() < 0.035


@pytest.mark.slow
def test_a_command_beyond_the_bases_limits_stops_the_robot(robot):
    url, _ = robot
    application = make_application(url)
    application.scenario.time_limit = 5.0
    # As if the program had not been told.
    application.station.link._upper[0] = 0.05
    done = run_on_hardware(application)
    assert done.run.outcome.startswith(
        f"{STOPPED}: the station stopped: the base's forward speed is"
        " commanded to be"
    )


@pytest.mark.slow
def test_an_exception_leaves_the_robot_at_rest(robot):
    url, client = robot
    application = make_application(url)

    def explode(t, error, report):
        if np.abs(application.station.link.u).max() > 0.2:
            raise ZeroDivisionError

    with commands_heard(url) as heard, pytest.raises(ZeroDivisionError):
        run_on_hardware(application, on_progress=explode)
    fastest = max(np.abs(u).max() for u in heard)
    assert fastest > 0.2
    assert not heard[-1].any()
    assert_stays_still(client)


def test_ctrl_c_leaves_the_robot_at_rest(robot):
    url, client = robot
    with subprocess.Popen(
        command_line(
            *(
                "run",
                "TableReach",
                "--hardware",
                "--without-doctor",
                "--headless",
            ),
            *("--lcm-url", url, "--scenario-text", PATIENT),
        ),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            with commands_heard(url) as heard:
                client.wait_for(lambda: moves(client))
                process.send_signal(signal.SIGINT)
                result, errors = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
    assert process.returncode == 130, errors
    assert "interrupted" in result
    assert np.abs(heard).max() > 0
    assert not heard[-1].any()
    assert_stays_still(client)


def test_a_silent_robot_is_named(capsys):
    url = free_url()
    line = complaint(
        capsys,
        *(
            "run",
            "--hardware",
            "--without-doctor",
            "--headless",
            "--lcm-url",
            url,
        ),
        *("--scenario-text", "{hardware: {connect_timeout: 0.2}}"),
    )
    for mention in ("PANDA_STATUS", "BASE_STATUS", url, "0.2 s"):
        assert mention in line


@pytest.mark.parametrize(
    ("arguments", "mention"),
    [
        (["--lcm-url", "udpm://239.255.76.67:7667?ttl=0"], "--hardware"),
        (["--hardware", "--lcm-url", "nowhere"], "'nowhere'"),
        (["--hardware"], "--rehearsal"),
        (["--hardware", "--rehearsal", "--lcm-url", "x"], "--lcm-url"),
        (["--rehearsal"], "--hardware"),
        (["--shadow"], "--hardware"),
        (["--hardware", "--realtime-rate", "2"], "--realtime-rate"),
        (
            ["--hardware", "--scenario-text", "{hardware: {frozen_after: 0}}"],
            "hardware.frozen_after",
        ),
        (
            ["--hardware", "--scenario-text", "{supervisor: {enabled: false}}"],
            "supervisor.enabled",
        ),
        (
            ["--hardware", "--scenario-text", "{controller: {verify: false}}"],
            "controller.verify",
        ),
    ],
)
def test_bad_flags_are_named(capsys, arguments, mention):
    assert mention in complaint(capsys, "run", *arguments)


def test_a_robot_that_no_doctor_has_seen_is_not_driven(
    capsys, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    line = complaint(
        capsys, "run", "--hardware", "--headless", "--lcm-url", free_url()
    )
    assert "doctor.json: no report about the robot" in line
    assert "--without-doctor" in line


@pytest.mark.parametrize(
    ("scenario", "named"),
    [
        (
            "TableReach",
            "base-step (--skip), user-stop (--skip), emergency-stop",
        ),
        ("Ur5eReach", "user-stop (--skip)"),
    ],
)
def test_a_skipped_drill_is_not_a_passed_one(capsys, tmp_path, scenario, named):
    """What `doctor --skip all` writes where all else is well."""
    url, path = free_url(), tmp_path / "doctor.json"
    findings = [
        Finding(name, SKIPPED, "--skip", "", "")
        if name in DRILLS
        else Finding(name, PASSED, "well", "well", "packets")
        for name in needed_checks(has_base=True)
    ]
    DoctorReport(this_host(), url, time.time(), tuple(findings)).save(path)
    line = complaint(
        capsys,
        *("run", scenario, "--hardware", "--headless", "--lcm-url", url),
        *("--doctor", str(path)),
        *("--scenario-text", "{hardware: {connect_timeout: 0.2}}"),
    )
    assert f"lacks checks: {named}" in line
    assert "--without-doctor" in line


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("supervisor: {enabled: false}", "supervisor.enabled"),
        ("controller: {verify: false}", "controller.verify"),
        ("controller: {gains: paper}", "controller.verify"),
        (
            "controller: {gains: paper, verify: true}",
            "controller.self_collision.enabled",
        ),
        ("control_period: 0.1", "control_period"),
        ("oracle: {min_opacity: 0.9}", "oracle.min_opacity"),
        ("oracle: {n_sigma: 0.1}", "oracle.n_sigma"),
        ("oracle: !DepthRasterization {alpha_cutoff: 1}", "alpha_cutoff"),
        ("supervisor: {robot_modes: [move, reflex]}", "robot_modes"),
        ("supervisor: {min_success_rate: 0}", "min_success_rate"),
        ("supervisor: {max_status_age: 1}", "max_status_age"),
        ("supervisor: {follow_dwell: 5}", "follow_dwell"),
    ],
)
def test_what_disarms_a_gate_is_for_simulations_only(text, field):
    scenario = load_scenario("TableReach", f"{{{text}}}")
    with pytest.raises(FieldError) as caught:
        prepare_for_hardware(scenario, None)
    assert field in caught.value.field
    assert "\n" not in str(caught.value)


def test_every_narrower_range_names_a_field_and_admits_its_default():
    oracles = (SphereToEllipsoid(), DepthRasterization(), GroundTruth())
    for oracle in oracles:
        check_for_hardware(Scenario(oracle=oracle))
    owners = [Scenario(oracle=oracle) for oracle in oracles]
    owners[0].hardware.localization = LocalizationConfig()
    check_for_hardware(owners[0])
    for field in (*NARROWER, *REQUIRED):
        assert any(has(owner, field) for owner in owners), field


def has(config, field: str) -> bool:
    for name in field.split("."):
        if not hasattr(config, name):
            return False
        config = getattr(config, name)
    return True


def test_the_program_learns_the_bases_limits():
    scenario = load_scenario(
        "TableReach",
        "{hardware: {base_forward_upper: 0.1, base_yaw_rate: 0.3},"
        " controller: {velocity_limits: {max_yaw_rate: 0.2}}}",
    )
    prepare_for_hardware(scenario, None)
    limits = scenario.controller.velocity_limits
    assert (limits.max_forward, limits.max_reverse) == (0.1, 0.25)
    assert limits.max_yaw_rate == 0.2


def test_a_real_robot_is_slow_until_a_person_raises_it():
    raised = load_scenario(
        "TableReach", "{controller: {path_tracking: {max_speed: 1.2}}}"
    )
    for scenario, path in ((load_scenario("TableReach"), 0.35), (raised, 1.2)):
        assert scenario.controller.servo.fastest == 1.0
        prepare_for_hardware(scenario, None)
        assert scenario.controller.servo.fastest == 0.35
        assert scenario.controller.path_tracking.max_speed == path
