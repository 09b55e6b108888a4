"""Searches the steps of a requested job: a grasp or a place, for example."""

import dataclasses as dc
from collections.abc import Callable, Mapping

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.step import Block

JobRequest = Callable[[JobMaker], tuple[Block, ...]]
"""A requested job, as a function that makes its steps. It can be pickled."""


@dc.dataclass(frozen=True, eq=False)
class FoundJob:
    """The result of a search.

    Attributes:
        blocks: The steps of the job; empty if it cannot begin.
        spheres: Spheres around the objects that may be carried, by name.
        problem: Why the job cannot begin; empty if it can.
    """

    blocks: tuple[Block, ...] = ()
    spheres: Mapping[str, LinkSpheres] = dc.field(default_factory=dict)
    problem: str = ""


JobSearch = Callable[[JobRequest, DistanceField], FoundJob | None]
"""Function of a request and the map without objects that returns the steps of
the job, or None while they are being searched. It is called with the same
request until it returns a result; a call with another request cancels the
search for the previous one."""


def search_job(
    maker: JobMaker, request: JobRequest, scene: DistanceField
) -> FoundJob:
    """Searches the steps of a job, which takes up to some seconds.

    Args:
        maker: Makes the steps.
        request: The job.
        scene: The map without the objects.
    """
    maker.scene = scene
    try:
        blocks = request(maker)
    except RemoSplatError as error:
        return FoundJob(problem=str(error))
    return FoundJob(blocks, dict(maker.spheres))
