"""Takes the wrist camera's images for the page."""

from collections.abc import Callable, Iterator
from time import monotonic, sleep

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.cockpit.messages import CockpitJob, PageContent
from remosplat_drake.signals.map_requests import scene_in_turn

_PERIOD = 0.1
"""Time between two pictures [s]."""

_SHARE = 0.25
"""The images of a simulated camera may take at most this fraction of a CPU
core's time."""

_LISTEN = 0.02
"""Time between two checks for a new image [s]."""


def wrist_pictures(
    job: CockpitJob, now: Callable[[], tuple[PageContent, int]]
) -> Iterator[Frame]:
    """Yields the wrist camera's image ten times a second, forever.

    If an image takes long to make, the next image follows later. While a camera
    sends no images, the generator yields nothing and continues to wait.

    Args:
        job: The settings of the cockpit, with the function that makes the
            camera.
        now: Function that returns the page's present content, and the number of
            requests so far to switch a simulated camera's scene.

    Raises:
        RemoSplatError: There is no such camera.
    """
    assert job.make_camera is not None
    camera = job.make_camera()
    changes, due = 0, -np.inf
    while True:
        camera.listen()
        content, wanted = now()
        scene = scene_in_turn(job.scenes, wanted)
        if scene is not None and wanted != changes:
            changes = wanted
            camera.show(scene)
        if monotonic() < due:
            sleep(_LISTEN)
            continue
        begun = monotonic()
        due = begun + _PERIOD
        try:
            frame = camera.frame(content.q, content.time)
        except RemoSplatError:
            continue
        due = max(due, begun + (monotonic() - begun) / _SHARE)
        yield frame
