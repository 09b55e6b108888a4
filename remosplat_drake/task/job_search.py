"""Searches for the steps of a requested job, such as a grasp or a place."""

import dataclasses as dc
from collections.abc import Callable, Mapping

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.object_finder import NewObject
from remosplat_drake.task.step import Block

JobRequest = Callable[[JobMaker], tuple[Block, ...] | NewObject]
"""A requested job, as a function that makes its steps, or finds an object. It
can be pickled."""


@dc.dataclass(frozen=True, eq=False)
class FoundJob:
    """The result of a search.

    Attributes:
        blocks: The steps of the job; empty if it cannot begin.
        spheres: Spheres around the objects that may be carried, by name.
        new: The object that the job has found; None if it finds none.
        problem: Reason why the job cannot begin; empty if it can begin.
    """

    blocks: tuple[Block, ...] = ()
    spheres: Mapping[str, LinkSpheres] = dc.field(default_factory=dict)
    new: NewObject | None = None
    problem: str = ""


JobSearch = Callable[[JobRequest, DistanceField], FoundJob | None]
"""Function that returns the steps of a job, or None while it searches for them.
Its arguments are the request and the map without objects. It is called with the
same request until it returns a result. A call with another request cancels the
search for the previous request."""


def search_job(
    maker: JobMaker, request: JobRequest, scene: DistanceField
) -> FoundJob:
    """Searches for the steps of a job; the search may take some seconds.

    Args:
        maker: The `JobMaker`, which makes the steps.
        request: The job.
        scene: The map without the objects.
    """
    maker.scene = scene
    try:
        made = request(maker)
    except RemoSplatError as error:
        return FoundJob(problem=str(error))
    if isinstance(made, NewObject):
        return FoundJob(new=made)
    return FoundJob(made, dict(maker.spheres))
