"""`aim_of`: converts the present step of a task to the controller's aim."""

import numpy as np

from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from remosplat_drake.task.task import Task, TaskState


def aim_of(task: Task, state: TaskState, q: np.ndarray) -> Aim:
    """Returns the targets of all end effectors in the present step.

    End effectors that the step does not move keep their poses. If the base
    drives, the aim also contains the final configuration: the base at its goal,
    and the arm as it was when the step began.

    Args:
        task: The task.
        state: The progress of the task.
        q: The configuration, shape (n_q,) [rad, m]. Before the first step, the
            aim consists of the end effectors' poses at q.
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
