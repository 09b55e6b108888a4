"""The application: every stage, wired together. The only place that does.

station --configuration--> oracle --clearances--> controller --> station
"""

import dataclasses as dc
import math

import numpy as np
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    OutputPort,
)
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    Multiplexer,
)

from remosplat_drake import resources
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick import ReactiveLaw
from remosplat_drake.errors import FieldError
from remosplat_drake.oracle.config import make_field
from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.robot.robot_model import RobotModel, load_robot_model
from remosplat_drake.scenario import Scenario, make_transform
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_rmmi
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.ply import read_ply
from remosplat_drake.station import ports
from remosplat_drake.station.simulated_station import MakeHardwareStation
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.views import AddViews


@dc.dataclass(frozen=True, eq=False)
class World:
    """What a scenario's files hold, loaded and placed in W.

    Attributes:
        robot: The robot.
        splat_W: The scene's splat, or None.
        truth: The scene's true geometry, or None.
        field: The oracle's map.
        q0: Configuration to start from, shape (n_q,).
    """

    robot: RobotModel
    splat_W: GaussianSplat | None
    truth: PrimitiveScene | None
    field: DistanceField
    q0: np.ndarray

    @property
    def truth_field(self) -> DistanceField | None:
        """Ground-truth distances, where the true geometry is known."""
        return None if self.truth is None else SignedDistanceField(self.truth)


@dc.dataclass(frozen=True, eq=False)
class Application:
    """A built diagram and the parts that a run looks at."""

    scenario: Scenario
    world: World
    diagram: Diagram
    station: Diagram
    oracle: DistanceOracle
    controller: ReactiveController
    targets: TargetSequence
    recorder: TrajectoryRecorder
    configuration: OutputPort


def load_world(scenario: Scenario) -> World:
    """Reads a scenario's files.

    Raises:
        RemoSplatError: A file or a field is unusable, or the robot would
            start inside the scene.
    """
    folder, where = scenario.folder, scenario.source
    robot = load_robot_model(
        scenario.robot.model,
        scenario.robot.spheres,
        scenario.scene.floor_height,
    )
    truth = None
    if scenario.scene.truth:
        truth = read_rmmi(resources.resolve(scenario.scene.truth, folder))
    splat_W = _load_splat(scenario)
    world = World(
        robot,
        splat_W,
        truth,
        make_field(scenario.oracle, splat_W, truth, where),
        _start(scenario, robot, truth),
    )
    _check_start(world, where)
    return world


def _load_splat(scenario: Scenario) -> GaussianSplat | None:
    scene = scenario.scene
    if not scene.splat:
        return None
    path = resources.resolve(scene.splat, scenario.folder)
    X_WG = make_transform(scene.X_WG, scenario.source, "scene.X_WG")
    splat_W = read_ply(path).transformed(X_WG)
    if scene.crop is not None:
        splat_W = splat_W.cropped(
            np.array(scene.crop.lower), np.array(scene.crop.upper)
        )
        if not len(splat_W):
            raise FieldError(scenario.source, "scene.crop", "leaves no splats")
    return splat_W


def _start(
    scenario: Scenario, robot: RobotModel, truth: PrimitiveScene | None
) -> np.ndarray:
    base = scenario.robot.base_pose
    if base is None and truth is not None and truth.X_WB_start is not None:
        base = list(truth.X_WB_start)
    arm = scenario.robot.arm
    if arm is None:
        arm = list(robot.home)
    if len(arm) != len(robot.home):
        raise FieldError(
            scenario.source,
            "robot.arm",
            f"expected {len(robot.home)} numbers, got {len(arm)}",
        )
    return np.array([*((base or [0.0] * 3) if robot.n_base else []), *arm])


def _check_start(world: World, where: str) -> None:
    robot, q0 = world.robot, world.q0
    outside = (q0 < robot.position_lower) | (q0 > robot.position_upper)
    if outside.any():
        joint = robot.joint_names[int(outside.argmax())]
        raise FieldError(where, "robot.arm", f"{joint} is beyond its limits")
    clearances = world.field.clearances(robot.spheres_at(q0))
    if clearances.minimum() < 0:
        row = int(clearances.distance.argmin())
        link = robot.spheres.links[clearances.sphere[row]]
        raise FieldError(
            where,
            "robot.base_pose",
            f"the robot would start inside the scene: {link} by "
            f"{-1e3 * clearances.minimum():.0f} mm",
        )


def MakeDiagram(
    scenario: Scenario, world: World, page: MeshcatPage | None = None
) -> Application:
    """Wires a scenario's stages into one diagram.

    Args:
        scenario: The experiment.
        world: What its files hold.
        page: A browser page to draw on.
    """
    robot, dt = world.robot, scenario.control_period
    builder = DiagramBuilder()
    station = builder.AddSystem(
        MakeHardwareStation(
            config=scenario.station,
            robot=robot,
            scene=world.truth,
            q0=world.q0,
            wrist_camera=scenario.wrist_camera,
        )
    )
    configuration = _AddConfiguration(builder, robot, station)
    targets = TargetSequence.AddToBuilder(
        builder,
        configuration=configuration,
        robot=robot,
        X_WTs=_targets(scenario, world),
        arrival=scenario.arrival,
        period=dt,
    )
    oracle = DistanceOracle.AddToBuilder(
        builder,
        robot=robot,
        field=world.field,
        max_distance=scenario.controller.collision.influence,
        configuration=configuration,
    )
    controller = ReactiveController.AddToBuilder(
        builder,
        law=ReactiveLaw.make(scenario.controller, robot, dt),
        oracle=oracle,
    )
    builder.Connect(configuration, controller.GetInputPort("configuration"))
    builder.Connect(
        targets.GetOutputPort("target"), controller.GetInputPort("target")
    )
    _ConnectCommand(builder, robot, controller, station)
    report = controller.GetOutputPort("report")
    recorder = TrajectoryRecorder.AddToBuilder(
        builder,
        configuration=configuration,
        report=report,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=dt,
    )
    if page is not None:
        AddViews(
            builder,
            page,
            robot=robot,
            splat_W=world.splat_W,
            truth=world.truth,
            configuration=configuration,
            report=report,
        )
    diagram = builder.Build()
    diagram.set_name("remosplat")
    return Application(
        scenario,
        world,
        diagram,
        station,
        oracle,
        controller,
        targets,
        recorder,
        configuration,
    )


def _targets(scenario: Scenario, world: World):
    targets = [
        make_transform(target, scenario.source, f"targets[{i}]")
        for i, target in enumerate(scenario.targets)
    ]
    if not targets and world.truth is not None and world.truth.X_WE_target:
        targets = [world.truth.X_WE_target]
    if not targets:
        raise FieldError(
            scenario.source, "targets", "none given, here or in scene.truth"
        )
    return targets


def _AddConfiguration(
    builder: DiagramBuilder, robot: RobotModel, station: Diagram
) -> OutputPort:
    """Stacks the station's measurements into the configuration q."""
    description = robot.description
    names = [ports.arm_position(description)]
    if robot.n_base:
        names.insert(0, ports.BASE_POSE)
    measured = [station.GetOutputPort(name) for name in names]
    multiplexer = builder.AddNamedSystem(
        "configuration", Multiplexer([port.size() for port in measured])
    )
    for i, port in enumerate(measured):
        builder.Connect(port, multiplexer.get_input_port(i))
    return multiplexer.get_output_port()


def _ConnectCommand(
    builder: DiagramBuilder,
    robot: RobotModel,
    controller: ReactiveController,
    station: Diagram,
) -> None:
    """Splits the command u between base and arm; holds the gripper open."""
    description = robot.description
    names = [ports.arm_command(description)]
    if robot.n_base:
        names.insert(0, ports.BASE_COMMAND)
    inputs = [station.GetInputPort(name) for name in names]
    demultiplexer = builder.AddNamedSystem(
        "command", Demultiplexer([port.size() for port in inputs])
    )
    builder.Connect(
        controller.GetOutputPort("velocity_commanded"),
        demultiplexer.get_input_port(),
    )
    for i, port in enumerate(inputs):
        builder.Connect(demultiplexer.get_output_port(i), port)
    if description.hand:
        open_width = math.fsum(
            description.locked.get(joint, 0.0)
            for joint in description.hand.joints
        )
        hand = builder.AddNamedSystem(
            "hand_command", ConstantVectorSource([open_width, 20.0])
        )
        builder.Connect(
            hand.get_output_port(),
            station.GetInputPort(ports.hand_command(description)),
        )
