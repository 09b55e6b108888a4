"""Adds the stages that describe the robot's state and record the run."""

from pydrake.systems.framework import DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.world import World
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.motion_status.motion_status_system import (
    MotionStatusSystem,
)
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.task.targets import Targets


def AddMotionStatus(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
    controller: ReactiveController,
    selector: GuidanceSelector | None,
    supervisor: SafetySupervisor | None,
    movers: OutputPort | None,
) -> MotionStatusSystem:
    """Adds the system that describes the robot's state in one sentence.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that outputs the targets of the end effectors.
        oracle: The system that outputs the map.
        controller: The controller whose reports are described.
        selector: The guidance selector beside the controller; None without
            guidance.
        supervisor: The safety supervisor; None without a supervisor.
        movers: The output port of the `Movers` that the robot perceives; None
            without movers.
    """
    inputs = {
        "configuration": configuration,
        "report": controller.GetOutputPort("report"),
        "distance_field": oracle.GetOutputPort("distance_field"),
    }
    if targets.HasOutputPort("progress"):
        inputs["progress"] = targets.GetOutputPort("progress")
    if selector is not None:
        inputs["selection"] = selector.GetOutputPort("selection")
    if supervisor is not None:
        inputs["supervision"] = supervisor.GetOutputPort("supervision")
    if movers is not None:
        inputs["movers"] = movers
    truth = world.truth
    return MotionStatusSystem.AddToBuilder(
        builder,
        inputs=inputs,
        robot=world.robot,
        arrival=scenario.arrival,
        period=scenario.control_period,
        parked=scenario.controller.velocity_limits.is_parked(
            world.robot.n_base
        ),
        floor_height=scenario.scene.floor_height,
        truth=None if truth is None else SignedDistanceField(truth),
    )


def AddRecorder(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    configuration: OutputPort,
    controller: ReactiveController,
    executed: OutputPort,
    movers: OutputPort | None = None,
    keep: float | None = None,
) -> TrajectoryRecorder:
    """Adds the recorder of configurations, tick reports and commands.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, which determines the lengths of q and u.
        configuration: The output port of the measured q, n_q entries.
        controller: The controller whose ticks are kept.
        executed: The output port of the command u that the station gets.
        movers: The output port of the `Movers`; None without movers.
        keep: Age at which ticks are dropped, for runs without an end [s]; None
            keeps all ticks.
    """
    return TrajectoryRecorder.AddToBuilder(
        builder,
        configuration=configuration,
        report=controller.GetOutputPort("report"),
        executed=executed,
        movers=movers,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=scenario.control_period,
        keep=keep,
    )
