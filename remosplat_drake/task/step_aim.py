"""`aim_of`: from the present step of a task to the aim of the controller."""

import numpy as np

from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from remosplat_drake.task.task import Task, TaskState


def aim_of(task: Task, state: TaskState, q: np.ndarray) -> Aim:
    """Returns where the present step goes; what it does not move stays.

    A step that drives names the configuration that it ends in: the present arm
    on the base where that goes.

    Args:
        task: The task.
        state: How far it is.
        q: The configuration, shape (n_q,) [rad, m], the aim before the first
            step.
    """
    step, robot = state.present(task), task.robot
    if state.X_WT is None or state.q_A is None:
        return Aim.of(robot.end_effector_poses(q)[step.effector])
    if step.drives:
        q_T, X_WB = state.q_A.copy(), state.X_WT
        q_T[:3] = *X_WB[:2, 3], np.arctan2(X_WB[1, 0], X_WB[0, 0])
        return Aim(tuple(map(Target, robot.end_effector_poses(q_T))), q=q_T)
    X_WA = robot.end_effector_poses(state.q_A)
    targets: list[Target | None] = [Target(X) for X in X_WA]
    target = Target(state.X_WT)
    if step.goal is not None and step.speed is not None and state.begun:
        target = target.on_line(X_WA[step.effector], step.speed)
    targets[step.effector] = target
    return Aim(tuple(targets))
