"""`AddViews`: adds the views of a run to a diagram, and connects them."""

from pydrake.systems.framework import DiagramBuilder, OutputPort

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.guidance_view import GuidanceView
from remosplat_drake.visualization.motion_status_view import MotionStatusView
from remosplat_drake.visualization.mover_view import MoverView
from remosplat_drake.visualization.object_view import ObjectView
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import AddRobotView
from remosplat_drake.visualization.run_view import RunView
from remosplat_drake.visualization.splat_view import SplatView
from remosplat_drake.visualization.task_view import TaskView
from remosplat_drake.visualization.truth_view import TruthView


def AddViews(
    builder: DiagramBuilder,
    page: MeshcatPage,
    *,
    robot: RobotModel,
    configuration: OutputPort,
    report: OutputPort,
    motion_status: OutputPort | None = None,
    splat_W: GaussianSplat | None = None,
    truth: PrimitiveScene | None = None,
    selection: OutputPort | None = None,
    movers: OutputPort | None = None,
    objects: OutputPort | None = None,
    outline: OutputPort | None = None,
) -> None:
    """Draws the scene, and adds the systems that draw robot and controller.

    Args:
        builder: Builder of the diagram.
        page: The page to draw on.
        robot: The robot that moves.
        configuration: Output port of the measured configuration q.
        report: Output port of the controller's `TickReport`.
        motion_status: Output port of the `MotionStatus`, the robot's state;
            None if the diagram has no such port.
        splat_W: The scene's splat in W; None if it has no splat.
        truth: The scene's true geometry; None if it is unknown.
        selection: Output port of the guidance selector's `Selection`; None
            without guidance.
        movers: Output port of the `Movers`; None if nothing moves.
        objects: Output port of the objects of a task; None without a task.
        outline: Output port of the `TaskOutline` of a task; None without a
            task.

    Example:
        >>> import remosplat_drake as rs
        >>> page = rs.MeshcatPage()
        >>> scenario = rs.load_scenario("TableGroundTruth")
        >>> application = rs.build(scenario, page=page)  # It calls AddViews.
    """
    if splat_W is not None:
        SplatView(page, splat_W)
    run_view = RunView.AddToBuilder(builder, page=page, robot=robot)
    builder.Connect(configuration, run_view.GetInputPort("configuration"))
    builder.Connect(report, run_view.GetInputPort("report"))
    if motion_status is not None:
        view = MotionStatusView.AddToBuilder(builder, page=page, robot=robot)
        builder.Connect(configuration, view.GetInputPort("configuration"))
        builder.Connect(motion_status, view.GetInputPort("motion_status"))
    if selection is not None:
        guidance_view = GuidanceView.AddToBuilder(builder, page=page)
        builder.Connect(selection, guidance_view.GetInputPort("selection"))
    if movers is not None:
        mover_view = MoverView.AddToBuilder(builder, page=page)
        builder.Connect(movers, mover_view.GetInputPort("movers"))
    if objects is not None:
        view = ObjectView.AddToBuilder(builder, page=page, robot=robot)
        builder.Connect(configuration, view.GetInputPort("configuration"))
        builder.Connect(report, view.GetInputPort("report"))
        builder.Connect(objects, view.GetInputPort("objects"))
    if outline is not None:
        task_view = TaskView.AddToBuilder(builder, page=page)
        builder.Connect(outline, task_view.GetInputPort("outline"))
    robot_input = AddRobotView(builder, robot, page)
    builder.Connect(configuration, robot_input)
    if truth is not None:
        TruthView(page, truth)
