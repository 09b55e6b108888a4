"""A robot before a table, its camera, and what goes wrong with cameras."""

import contextlib
import dataclasses as dc
import os
import resource
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import numpy as np
from patience import PATIENCE
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.rendered_camera import RenderedCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.mapping.mapping_job import MappingJob
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.mapping.messages import AddFrame, Event
from remosplat_drake.mapping.store.session import Session
from remosplat_drake.oracle.oracle_config import (
    OracleMaker,
    SphereToEllipsoid,
    make_field,
)

CAMERA = WristCameraConfig(width=96, height=72)
CONFIG = MappingConfig(
    voxel=0.1,
    volume_lower=[-1.0, -1.0, 0.0],
    volume_upper=[2.0, 1.0, 1.5],
    discs=2000,
)

SILENT, MISPLACED = 1000.0, 2000.0
"""Times at which this camera does not work as it should."""

LARGEST = {3000.0: 1_000, 4000.0: 40_000}
"""From such a time on its process writes so many bytes a file at most: less
than a frame has, or more, but less than a map. Until the next picture."""


class UnreliableCamera(RenderedCamera):
    """Silent at one time, somewhere else at another; and fills the disk."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """See `RenderedCamera.frame`."""
        if time == SILENT:
            raise RemoSplatError("the wrist camera sends no images")
        _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
        largest = LARGEST.get(time, most)
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, most))
        frame = super().frame(q, time)
        if time == MISPLACED:
            X_WC = frame.X_WC.copy()
            X_WC[:3, 3] += 0.25
            frame = dc.replace(frame, X_WC=X_WC)
        return frame


@cache
def table_world() -> World:
    """The default scenario's world, with its true geometry."""
    return load_world(load_scenario())


def make_camera(world: World) -> RenderedCamera:
    """A camera before the table; its process is as urgent as the tests."""
    # Where the tests may not do that, they take longer on a busy computer.
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, 0)
    return UnreliableCamera(CAMERA, world.robot, world.truth)


X_CD = RigidTransform(RollPitchYaw(np.deg2rad([0.6, -0.64, 0.48])), [0, 0, 0])
"""Pose of a tilted camera D in the one that its mount says, C."""


class TiltedCamera(RenderedCamera):
    """Sits turned by 1 degree on its mount, which does not know it."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """See `RenderedCamera.frame`."""
        frame = super().frame(q, time)
        X_DC = X_CD.inverse().GetAsMatrix4()
        return dc.replace(frame, X_WC=frame.X_WC @ X_DC)


def make_tilted_camera(world: World) -> RenderedCamera:
    """A tilted camera, with the images of the shipped one."""
    return TiltedCamera(WristCameraConfig(), world.robot, world.truth)


def make_job(
    world: World,
    folder: Path,
    config: MappingConfig = CONFIG,
    make: Callable = make_camera,
    oracle: OracleMaker | None = None,
) -> MappingJob:
    """A new session's job."""
    Session.create(folder, "robot: {model: frankie}\n")
    return MappingJob(
        folder,
        config,
        world.robot,
        partial(make, world),
        partial(
            make_field,
            oracle or SphereToEllipsoid(),
            truth=None,
            where="test",
        ),
        world.q0,
    )


def looking_around(world: World, count: int, seed: int = 0) -> list[np.ndarray]:
    """Configurations near the start, shape (10,) each."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(-0.12, 0.12, (count, 7))
    return [world.q0 + np.concatenate([np.zeros(3), turn]) for turn in turns]


def take_frames(
    process: MappingProcess, world: World, count: int = 4, seed: int = 0
) -> None:
    """Asks for frames from different poses."""
    for i, q in enumerate(looking_around(world, count, seed)):
        process.request(AddFrame(q, 1.0 + i))


def answers(process: MappingProcess) -> list[Event]:
    """All that the process tells until it has nothing left to do."""
    events = process.wait(process.sent)
    return events + process.poll()


def until_told(process: MappingProcess) -> list[Event]:
    """The next events that come, without anything being asked."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if events := process.poll():
            return events
        time.sleep(0.01)
    raise AssertionError("the process is silent")
