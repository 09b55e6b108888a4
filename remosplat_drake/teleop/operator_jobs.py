"""`advance_jobs`: advances an operator's jobs with objects by one tick.

An operator's request starts a job: an object is found in the map, or the robot
takes an object, places it, or lets it go. While another function searches for
the object or for the steps of a job, the robot is held. The steps are executed
like those of a task (`task.advance_task`). A job ends when its steps are
finished, when it fails, when the operator holds the target, or when the robot
is stopped. The robot then brakes. When it is at rest, the operator moves the
target again.
"""

import dataclasses as dc
from collections.abc import Mapping
from functools import partial

import numpy as np

from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.task.advance_task import (
    Observation,
    advance_task,
    has_slipped,
    loss,
)
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.job_search import FoundJob, JobRequest, JobSearch
from remosplat_drake.task.lost_load import lost_load
from remosplat_drake.task.object_finder import NewObject
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
"""Reasons why a job ends before its steps are finished."""


@dc.dataclass(frozen=True, eq=False)
class Wanted:
    """A requested job whose steps are being searched.

    Attributes:
        request: The job.
        thing: Name of the object that the job takes; empty if it takes none.
        at_rest: Whether the search begins when the robot is at rest.
    """

    request: JobRequest
    thing: str = ""
    at_rest: bool = False


@dc.dataclass(frozen=True, eq=False)
class Jobs(Work):
    """The state of an operator's jobs; a deep copy is the object itself.

    The blocks of `task` are the steps of the latest job.

    Attributes:
        command: The operator's requests so far.
        is_braking: Whether the latest job has ended, but the robot is not yet
            at rest.
        R_WO: Rotations of the objects before they were taken, keyed by name,
            shape (3, 3).
        is_lost: Whether the carried object may have been lost.
        wanted: The job whose steps are being searched; None without a search.
        scene: The map without the objects; None if the map changes during the
            run.
    """

    command: OperatorCommand = dc.field(default_factory=OperatorCommand)
    is_braking: bool = False
    R_WO: Mapping[str, np.ndarray] = dc.field(default_factory=dict)
    is_lost: bool = False
    wanted: Wanted | None = None
    scene: SceneMap | None = None

    @staticmethod
    def none(task: Task, scene: SceneMap | None = None) -> "Jobs":
        """Returns the state before the first request of an operator.

        Args:
            task: The robot and the objects, without blocks.
            scene: The map without the objects; None if it changes during the
                run.
        """
        return Jobs(task, TaskState(task.objects, outcome=DONE), scene=scene)

    @property
    def runs(self) -> bool:
        """Whether a job moves the robot."""
        return self.state.outcome == RUNNING and self.wanted is None

    @property
    def leads(self) -> bool:
        """Whether a job, and not the operator, moves or holds the robot."""
        return self.runs or self.is_braking or self.wanted is not None

    @property
    def text(self) -> str:
        """Description of the job's state; empty if the operator leads."""
        if not self.leads:
            return ""
        job, state = self.task.blocks[-1].text, self.state
        if self.wanted is not None:
            return f"hold: {job}: searches how"
        if self.runs:
            job = self.task.blocks[state.block].text
            step = state.present(self.task).text
            return job if step == job else f"{job}: {step}"
        if state.outcome == DONE:
            return f"hold: {job}: done"
        return f"hold: {job}: {state.failures[-1]}"


def advance_jobs(
    search: JobSearch,
    jobs: Jobs,
    command: OperatorCommand,
    now: Observation,
    scene: DistanceField,
    *,
    is_stopped: bool,
) -> Jobs:
    """Advances the jobs by one tick.

    Args:
        search: Function that searches for the steps of a job.
        jobs: The jobs at the previous tick.
        command: All requests of the operators so far.
        now: The measurements of the robot.
        scene: The map without the objects.
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
    if end and (jobs.runs or jobs.wanted):
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
    if jobs.is_braking:  # A request waits until the robot is at rest.
        return dc.replace(jobs, command=before)
    if jobs.wanted is None:
        jobs = _asked(jobs, before, now)
    wanted = jobs.wanted
    if wanted is not None and (now.stands_still or not wanted.at_rest):
        found = search(wanted.request, scene)
        return jobs if found is None else _begun(jobs, found, now)
    return jobs


def _ended(jobs: Jobs, reason: str) -> Jobs:
    """Ends a job before its steps are finished."""
    failures = (*jobs.state.failures, reason)
    state = dc.replace(jobs.state, failures=failures, outcome=FAILED)
    return _over(dc.replace(jobs, wanted=None), state)


def _over(jobs: Jobs, state: TaskState) -> Jobs:
    if state is jobs.state:
        return jobs
    return dc.replace(jobs, state=state, is_braking=state.outcome != RUNNING)


def _cleared(jobs: Jobs, now: Observation) -> Jobs:
    """Ends the contacts of the latest job when the robot is at rest.

    If the robot is too near to an object, these contacts end later. A carried
    object that has been lost becomes an obstacle, unless the robot is in the
    obstacle's space.
    """
    if not now.stands_still:
        return jobs
    state = jobs.state
    if jobs.is_lost and has_slipped(state, now):
        after = lost_load(jobs.task.robot, state, now.q)
        if not jobs.task.permission(state, after, now.q):
            state = after
    elif state.rules:
        clear = dc.replace(state, rules=())
        if not jobs.task.permission(state, clear, now.q):
            state = clear
    return dc.replace(jobs, state=state, is_braking=False)


def _asked(jobs: Jobs, before: OperatorCommand, now: Observation) -> Jobs:
    """Begins the search for the job of a request, if there is a new request."""
    command, state = jobs.command, jobs.state
    if command.takes > before.takes:
        names, thing = jobs.task.robot.effectors, command.thing
        chosen = command.effector
        effector = names.index(chosen) if chosen in names else 0
        take = partial(
            JobMaker.take, name=thing, state=state, q=now.q, effector=effector
        )
        return _searching(jobs, f"pick the {thing}", Wanted(take, thing))
    if command.places > before.places:
        place = partial(
            JobMaker.place,
            support=command.support,
            state=state,
            q=now.q,
            rotation=jobs.R_WO.get(state.held, np.eye(3)),
            near=command.p_WNear,
        )
        thing = state.held or "object"
        return _searching(jobs, f"place the {thing}", Wanted(place))
    if command.finds > before.finds and command.p_WFind is not None:
        find = partial(
            JobMaker.find,
            near=command.p_WFind,
            scene=jobs.scene,
            state=state,
        )
        return _searching(jobs, "find an object", Wanted(find, at_rest=True))
    if command.opens > before.opens and state.held:
        release = partial(JobMaker.release, state=state)
        return _searching(jobs, f"release the {state.held}", Wanted(release))
    return jobs


def _searching(jobs: Jobs, text: str, wanted: Wanted) -> Jobs:
    """Shows a job without steps, until its steps are found."""
    empty = (Block(text, ((),)),)
    jobs = _with_job(jobs, empty, failures=(), outcome=RUNNING)
    return dc.replace(jobs, wanted=wanted)


def _begun(jobs: Jobs, found: FoundJob, now: Observation) -> Jobs:
    """Starts a job with the found steps, or reports why none were found."""
    wanted, jobs = jobs.wanted, dc.replace(jobs, wanted=None)
    assert wanted is not None
    if found.problem:
        return _refused(jobs, jobs.task.blocks[-1].text, found.problem)
    if found.new is not None:
        return _with_object(jobs, found.new, now)
    task = dc.replace(jobs.task, spheres={**jobs.task.spheres, **found.spheres})
    if wanted.thing:
        R_WO = jobs.state.named(wanted.thing).X_WO.rotation().matrix()
        stood = {**jobs.R_WO, wanted.thing: R_WO}
        jobs = dc.replace(jobs, R_WO=stood, is_lost=False)
    return _with_job(
        dc.replace(jobs, task=task),
        found.blocks,
        begun=False,
        since=now.time,
        X_WT=None,
        q_A=None,
        carried=jobs.state.load,
        failures=(),
        outcome=RUNNING,
    )


def _with_object(jobs: Jobs, new: NewObject, now: Observation) -> Jobs:
    """Adds an object that was found, in place of its part of the map.

    The permission is checked with the whole map. The robot may be nearer to the
    object than to the map, since the object's shape contains its Gaussians.
    """
    objects = (*jobs.state.objects, new.thing)
    after = dc.replace(jobs.state, objects=objects)
    reason = jobs.task.permission(jobs.state, after, now.q)
    if reason:
        return _refused(jobs, jobs.task.blocks[-1].text, reason)
    done = (Block(f"find an object: {new.text}", ((),)),)
    jobs = _with_job(jobs, done, objects=objects, failures=(), outcome=DONE)
    return dc.replace(jobs, scene=new.scene, is_braking=True)


def _refused(jobs: Jobs, text: str, reason: str) -> Jobs:
    """Reports a job that cannot begin."""
    empty = (Block(text, ((),)),)
    jobs = _with_job(jobs, empty, failures=(reason,), outcome=FAILED)
    return dc.replace(jobs, is_braking=True, wanted=None)


def _with_job(jobs: Jobs, blocks: tuple[Block, ...], **changes) -> Jobs:
    """Replaces the job by another job, which is at its first step."""
    task = dc.replace(jobs.task, blocks=blocks)
    state = dc.replace(
        jobs.state, block=0, way=0, step=0, undoing=(), **changes
    )
    return dc.replace(jobs, task=task, state=state)
