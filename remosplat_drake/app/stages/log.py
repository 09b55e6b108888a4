"""Adds the stage that logs a run's ticks and events."""

from pathlib import Path

from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort

from remosplat_drake.app.control_loop import ControlLoop
from remosplat_drake.recording.mcap.mcap_recorder import McapRecorder
from remosplat_drake.recording.trajectory_log import TrajectoryLog


def log_inputs(
    loop: ControlLoop, live_map: LeafSystem | None
) -> dict[str, OutputPort]:
    """Returns the output ports that the log reads, keyed by input name.

    Args:
        loop: The control loop, with or without a supervisor.
        live_map: The map that grows during the run; None without a live map.
    """
    ports = {
        "report": loop.report,
        "motion_status": loop.motion_status.GetOutputPort("motion_status"),
    }
    if loop.supervisor is not None:
        ports["supervision"] = loop.supervisor.GetOutputPort("supervision")
    if live_map is not None:
        ports["map_status"] = live_map.GetOutputPort("map_status")
    return ports


def AddLog(
    builder: DiagramBuilder,
    loop: ControlLoop,
    folder: Path | None,
    live_map: LeafSystem | None,
    target: LeafSystem | None,
    recorder: McapRecorder | None,
) -> TrajectoryLog:
    """Adds the log that writes every tick and every event to disk.

    Args:
        builder: The builder of the diagram.
        loop: The control loop whose ticks are written.
        folder: Folder of a teleoperation's run, for the log; None for other
            runs, which have no folder.
        live_map: The map whose events are written; None without a live map.
        target: The target of a teleoperation's operator; None in other runs.
        recorder: Writer of the run as an MCAP file; None writes no such file.

    Raises:
        FileError: The files of the log cannot be made.
    """
    robot = loop.world.robot
    inputs = {
        **log_inputs(loop, live_map),
        "velocity_executed": loop.executed,
        "station_status": loop.status,
    }
    if target is not None:
        inputs["target_state"] = target.GetOutputPort("state")
        inputs["map_requests"] = target.GetOutputPort("map_requests")
    return TrajectoryLog.AddToBuilder(
        builder,
        inputs=inputs,
        folder=folder,
        recorder=recorder,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=loop.scenario.control_period,
    )
