"""Adds the stage that offers alternative targets on a simulated run's page."""

from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.app.control_loop import ControlLoop
from remosplat_drake.cockpit.page_offers import PageOffers
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.visualization.page import MeshcatPage


def AddPageOffers(
    builder: DiagramBuilder, loop: ControlLoop, page: MeshcatPage
) -> None:
    """Adds buttons for alternative targets that the robot can reach.

    Nothing is added if the robot has several end effectors, or if the scenario
    has no sequence of targets.

    Args:
        builder: The builder of the diagram.
        loop: The control loop of a simulated robot.
        page: The page that gets the buttons.
    """
    robot, targets = loop.world.robot, loop.targets
    is_single = len(robot.effectors) == 1
    if not (isinstance(targets, TargetSequence) and is_single):
        return
    config = loop.scenario.controller
    offers = builder.AddSystem(
        PageOffers(
            page=page,
            robot=robot,
            planner=MotionPlanner(
                robot, loop.law.self_clearance, config.guidance.planning
            ),
            stopping=config.collision.stopping,
        )
    )
    for source, name in (
        (loop.configuration, "configuration"),
        (loop.report, "report"),
        (loop.motion_status.GetOutputPort("motion_status"), "motion_status"),
        (loop.oracle.GetOutputPort("distance_field"), "distance_field"),
    ):
        builder.Connect(source, offers.GetInputPort(name))
    builder.Connect(
        offers.GetOutputPort("instead"), targets.GetInputPort("instead")
    )
