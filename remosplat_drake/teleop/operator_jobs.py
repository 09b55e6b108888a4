"""`advance_jobs`: an operator's jobs with objects, as a pure function.

A request starts a job: it takes an object, places it, or lets it go. The steps
of a job are those of a task (`task.advance_task`). A job ends when it is done,
when it fails, when the operator holds the target, or when the robot is stopped.
The robot then brakes, and when it is at rest the operator leads again.
"""

import dataclasses as dc
from collections.abc import Callable, Mapping

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.task.advance_task import (
    Observation,
    advance_task,
    loss,
)
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.step import Block
from remosplat_drake.task.task import (
    DONE,
    FAILED,
    RUNNING,
    Task,
    TaskState,
    Work,
)

STOPPED, HELD = "the robot was stopped", "the operator ended the job"
"""Reasons why a job ends before it is done."""


@dc.dataclass(frozen=True, eq=False)
class Jobs(Work):
    """An operator's jobs; copying returns the object itself.

    The blocks of `task` are those of the latest job.

    Attributes:
        command: The operator's requests so far.
        is_braking: Whether the latest job is over, and the robot not yet at
            rest.
        R_WO: Rotations with which objects stood when they were taken, by name,
            shape (3, 3).
        is_lost: Whether the carried object may have been lost.
    """

    command: OperatorCommand = dc.field(default_factory=OperatorCommand)
    is_braking: bool = False
    R_WO: Mapping[str, np.ndarray] = dc.field(default_factory=dict)
    is_lost: bool = False

    @staticmethod
    def none(task: Task) -> "Jobs":
        """Returns the jobs of an operator who has requested none.

        Args:
            task: The robot and the objects, without blocks.
        """
        return Jobs(task, TaskState(task.objects, outcome=DONE))

    @property
    def runs(self) -> bool:
        """Whether a job moves the robot."""
        return self.state.outcome == RUNNING

    @property
    def leads(self) -> bool:
        """Whether a job moves or brakes the robot, and not the operator."""
        return self.runs or self.is_braking

    @property
    def text(self) -> str:
        """The state of the job in words; empty if the operator leads."""
        if not self.leads:
            return ""
        job, state = self.task.blocks[-1].text, self.state
        if self.runs:
            job = self.task.blocks[state.block].text
            step = state.present(self.task).text
            return job if step == job else f"{job}: {step}"
        if state.outcome == DONE:
            return f"hold: {job}: done"
        return f"hold: {job}: {state.failures[-1]}"


def advance_jobs(
    maker: JobMaker,
    jobs: Jobs,
    command: OperatorCommand,
    now: Observation,
    *,
    is_stopped: bool,
) -> Jobs:
    """Advances the jobs by one tick.

    Args:
        maker: Makes the steps of a job.
        jobs: The jobs at the previous tick.
        command: All requests of the operators so far.
        now: The measurements of the robot.
        is_stopped: Whether the supervisor has stopped the robot.
    """
    if not np.isfinite(now.q).all():
        return jobs
    before, jobs = jobs.command, dc.replace(jobs, command=command)
    end = ""
    if is_stopped:
        end = STOPPED
    elif command.holds > before.holds:
        end = HELD
    if jobs.runs and end:
        return _ended(jobs, end)
    if jobs.runs:
        return _over(jobs, advance_task(jobs.task, jobs.state, now))
    jobs = _cleared(jobs, now)
    lost = loss(jobs.state, now)
    if lost and not jobs.is_lost:
        jobs = dc.replace(jobs, is_lost=True)
        return _refused(jobs, f"carry the {jobs.state.held}", lost)
    if end:
        return jobs
    if jobs.leads:  # A request waits until the robot is at rest.
        return dc.replace(jobs, command=before)
    return _begun(maker, jobs, before, now)


def _ended(jobs: Jobs, reason: str) -> Jobs:
    """Ends a job before it is done."""
    failures = (*jobs.state.failures, reason)
    state = dc.replace(jobs.state, failures=failures, outcome=FAILED)
    return _over(jobs, state)


def _over(jobs: Jobs, state: TaskState) -> Jobs:
    if state is jobs.state:
        return jobs
    return dc.replace(jobs, state=state, is_braking=state.outcome != RUNNING)


def _cleared(jobs: Jobs, now: Observation) -> Jobs:
    """Ends the contacts of the latest job when the robot is at rest.

    If the robot is too near to an object for that, they end later.
    """
    if not now.stands_still:
        return jobs
    state = jobs.state
    if state.rules:
        clear = dc.replace(state, rules=())
        if not jobs.task.permission(state, clear, now.q):
            state = clear
    return dc.replace(jobs, state=state, is_braking=False)


def _begun(
    maker: JobMaker, jobs: Jobs, before: OperatorCommand, now: Observation
) -> Jobs:
    """Starts the job of a new request, if there is one."""
    command, state = jobs.command, jobs.state
    robot = jobs.task.robot
    if command.takes > before.takes:
        names = robot.effectors
        chosen = command.effector
        effector = names.index(chosen) if chosen in names else 0

        def take() -> tuple[Block, ...]:
            return maker.take(command.thing, state, now.q, effector)

        jobs = _started(jobs, f"pick the {command.thing}", take, now)
        if jobs.runs:
            R_WO = state.named(command.thing).X_WO.rotation().matrix()
            stood = {**jobs.R_WO, command.thing: R_WO}
            return dc.replace(jobs, R_WO=stood, is_lost=False)
        return jobs
    if command.places > before.places:

        def place() -> tuple[Block, ...]:
            R_WO = jobs.R_WO.get(state.held, np.eye(3))
            return maker.place(
                command.support, state, now.q, R_WO, command.p_WNear
            )

        thing = state.held or "object"
        return _started(jobs, f"place the {thing}", place, now)
    if command.opens > before.opens and state.held:

        def release() -> tuple[Block, ...]:
            return maker.release(state)

        return _started(jobs, f"release the {state.held}", release, now)
    return jobs


def _started(
    jobs: Jobs,
    text: str,
    make: Callable[[], tuple[Block, ...]],
    now: Observation,
) -> Jobs:
    try:
        blocks = make()
    except RemoSplatError as error:
        return _refused(jobs, text, str(error))
    return _with_job(
        jobs,
        blocks,
        begun=False,
        since=now.time,
        X_WT=None,
        q_A=None,
        carried=jobs.state.load,
        failures=(),
        outcome=RUNNING,
    )


def _refused(jobs: Jobs, text: str, reason: str) -> Jobs:
    """Reports a job that cannot begin."""
    empty = (Block(text, ((),)),)
    jobs = _with_job(jobs, empty, failures=(reason,), outcome=FAILED)
    return dc.replace(jobs, is_braking=True)


def _with_job(jobs: Jobs, blocks: tuple[Block, ...], **changes) -> Jobs:
    """Replaces the job by another one, which is at its first step."""
    task = dc.replace(jobs.task, blocks=blocks)
    state = dc.replace(
        jobs.state, block=0, way=0, step=0, undoing=(), **changes
    )
    return dc.replace(jobs, task=task, state=state)
