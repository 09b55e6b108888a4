"""Runs in the mapping process: takes pictures and builds maps.

Only this process uses the camera and writes the session's folder. All its state
is in this folder, so a new process can continue if it was killed.
"""

import dataclasses as dc
import logging
import os
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from time import monotonic, sleep

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import (
    MIN_DEPTH_FRACTION,
    MIN_VIEWS,
)
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.build_thread import BuildThread
from remosplat_drake.mapping.camera_suspicion import (
    LEAST_FRAMES,
    Judgement,
)
from remosplat_drake.mapping.frame_choice import (
    contradicting_frames,
    contradiction,
    frames_to_keep,
    hides_view_of,
)
from remosplat_drake.mapping.hide_movers import hide_movers
from remosplat_drake.mapping.localization.frame_aligner import (
    Graph,
    Key,
    make_aligner,
    one_frame,
    vagueness,
)
from remosplat_drake.mapping.mapping_job import (
    MappingJob,
    UsableFrames,
    WrittenMap,
    next_judgement,
    next_map,
)
from remosplat_drake.mapping.messages import (
    AddFrame,
    Build,
    Close,
    Event,
    FrameAdded,
    FrameRefused,
    Idle,
    Located,
    MapReady,
    Note,
    Request,
    Save,
    ShowScene,
    Track,
    Trouble,
    Undo,
)
from remosplat_drake.mapping.store.map_file import open_map, write_map
from remosplat_drake.mapping.store.session import Session
from remosplat_drake.robot.planar_pose import odometry_frame
from remosplat_drake.scene.mover import Movers
from remosplat_drake.splat.codecs.ply import write_ply

_LOOK = 0.01
"""Time between two checks for new messages of the camera, and for progress of
the map under construction [s].
"""

_NEWS = 0.2
"""The progress of a map is reported once in this time [s]."""

_log = logging.getLogger(__name__)


def serve(connection: Connection, job: MappingJob) -> None:
    """Runs the mapping process until the other end of its pipe is closed.

    Then the process ends by `os._exit`, which abandons a map under
    construction.

    Args:
        connection: Pipe from which requests are read and to which events are
            written; see `messages`.
        job: All inputs of the process.
    """
    try:
        try:
            worker = _Worker(connection, job)
        except RemoSplatError as error:
            _refuse_all(connection, str(error))
        else:
            worker.run()
    except (EOFError, ConnectionError):
        pass
    except Exception:
        _log.exception("the mapping process ends")
    finally:
        # A map under construction is abandoned; all other data are already
        # saved.
        os._exit(0)


def _refuse_all(connection: Connection, reason: str) -> None:
    """Answers each request with the reason why no map can be built."""
    connection.send(Trouble(reason))
    answered = 0
    while not isinstance(connection.recv(), Close):
        answered += 1
        connection.send(Trouble(reason))
        connection.send(Idle(answered))


class _Worker:
    """Takes pictures at once, and builds maps one after another."""

    def __init__(self, connection: Connection, job: MappingJob):
        self._connection = connection
        self._job = job
        self._session = Session.open_to_write(job.session)
        self._camera = job.make_camera()
        self._aligner = make_aligner(job.config, job.robot)
        self._graph: Graph | None = None
        self._builder: BuildThread[WrittenMap | Judgement] = BuildThread()
        self._judgement: Judgement | None = None
        self._seals: dict[int, str] = {}
        self._wanted = self._judged_for = ""
        self._offered: set[str] = set()
        self._received = self._answered = 0
        self._told = 0.0
        # With a fixed latency, each request is finished before the next is
        # read, so that the content of maps does not depend on computing time.
        self._in_order = job.config.latency is not None

    def run(self) -> None:
        """Runs until the other end requests a stop, or is closed."""
        self._try(self._resume)
        self._try(self._tell_map)
        while True:
            self._camera.listen()
            self._advance_building()
            if self._in_order and self._builder.is_busy:
                sleep(_LOOK)
            elif self._connection.poll(_LOOK):
                request = self._connection.recv()
                if isinstance(request, Close):
                    return
                if self._in_order or not isinstance(request, Track):
                    self._received += 1
                self._try(partial(self._do, request))

    def _tell(self, event: Event) -> None:
        self._connection.send(event)

    def _tell_map(self) -> None:
        """Announces the map in use."""
        path, version = self._session.head_map, self._session.head
        correction = None
        if self._aligner is not None:
            correction = self._aligner.correction
        self._tell(MapReady(path, version, self._seal(version), correction))

    def _seal(self, version: int) -> str:
        """Returns the seal of a map's file; empty for the scenario's own map.

        The control process has no time to check a file from another process. So
        this process checks the file, and writes it again.
        """
        if version and version not in self._seals:
            path = self._session.map_path(version)
            self._seals[version] = write_map(path, open_map(path))
        return self._seals.get(version, "")

    def _try(self, action: Callable[[], None]) -> None:
        """Runs an action, reports its errors, and continues."""
        try:
            action()
        except (EOFError, ConnectionError):
            raise
        except RemoSplatError as error:
            self._tell(Trouble(str(error)))
        except Exception as error:
            _log.exception("the mapping process continues after an error")
            self._tell(Trouble(f"{type(error).__name__}: {error}"))

    def _do(self, request: Request) -> None:
        match request:
            case AddFrame():
                self._add_frame(request)
            case Track(q=q, time=taken, passing=passing):
                self._track(q, taken, passing)
            case Build(effort):
                self._want(effort)
            case Undo():
                self._undo()
            case Save():
                self._save()
            case ShowScene(scene=scene):
                self._camera.show(scene)

    def _want(self, effort: str) -> None:
        """Schedules a map, to be built after the one under construction."""
        if self._wanted != "full":
            self._wanted = effort

    def _add_frame(self, request: AddFrame) -> None:
        q, passing = request.q, request.passing
        self._camera.place(request.objects)
        frame = self._camera.frame(q, request.time)
        if (frame.depth > 0).mean() < MIN_DEPTH_FRACTION:
            self._tell(FrameRefused("the frame has no depth"))
            return
        frame = hide_movers(frame, passing, self._odometry_frame(frame, q))
        if (frame.depth > 0).mean() < MIN_DEPTH_FRACTION:
            self._tell(FrameRefused("movers cover most of the frame"))
            return
        name = self._session.frames.add(frame, q, request.objects)
        self._session.activate(name)
        if self._aligner is not None:
            key = (name, self._session.frames.time(name))
            tracked = self._aligner.track(one_frame(frame, q[:3], key[1]), key)
            if tracked.problem:
                self._refuse({name: f"{name} {tracked.problem}"})
                return
        self._tell(FrameAdded(name, len(self._session.active)))

    def _odometry_frame(self, frame: Frame, q: np.ndarray) -> np.ndarray:
        """Returns the estimate of X_WO at a frame, shape (3,)."""
        if self._aligner is None or frame.time is None:
            return np.zeros(3)
        X_WB, _ = self._aligner.correction.base_at(frame.time, q[:3])
        return odometry_frame(X_WB, q[:3])

    def _track(self, q: np.ndarray, taken: float, passing: Movers) -> None:
        """Localises the base, and always sends an answer."""
        assert self._aligner is not None
        try:
            frame = self._camera.frame(q, taken)
            frame = hide_movers(frame, passing, self._odometry_frame(frame, q))
            time = taken if frame.time is None else frame.time
            self._aligner.track(one_frame(frame, q[:3], time))
        finally:
            self._tell(Located(self._aligner.correction))

    def _resume(self) -> None:
        """Restores the aligner from frames that an earlier process aligned."""
        names, frames = self._session.active, self._session.frames
        if self._aligner is None or all(
            map(self._aligner.knows, self._keys(names))
        ):
            return
        self._refuse(frames.load(names))
        names = self._session.active
        X_OB = frames.configurations(names)[:, :3]
        for key, pose in zip(self._keys(names), X_OB, strict=True):
            if not self._aligner.knows(key):
                frame = one_frame(frames.frame(key[0]), pose, key[1])
                self._aligner.resume(frame, key, frames.base_pose(key[0]))

    def _undo(self) -> None:
        session = self._session
        if self._builder.is_busy or self._wanted or session.has_new_frames:
            self._builder.drop()
            self._wanted = ""
            session.leave_out_new_frames()
            self._tell(Note("frames that were in no map yet are dropped"))
            return
        self._seal(session.parent)  # If that fails, nothing has changed.
        session.undo()
        self._tell_map()

    def _save(self) -> None:
        if self._session.head_map is None:
            raise RemoSplatError("there is no map to save")
        splat_W = open_map(self._session.head_map).splat_W
        if splat_W is None:
            raise RemoSplatError("the map has no splat to save")
        path = self._session.folder / "splat.ply"
        write_ply(path, splat_W)
        self._tell(Note(f"saved {path}"))

    def _advance_building(self) -> None:
        if monotonic() > self._told + _NEWS:
            self._told = monotonic()
            if progress := self._builder.progress():
                self._tell(progress)
        result = self._builder.fetch()
        if isinstance(result, RemoSplatError):
            self._tell(Trouble(f"no new map: {result}"))
        elif isinstance(result, Exception):
            _log.error("no new map", exc_info=result)
            name = type(result).__name__
            self._tell(Trouble(f"no new map: {name}: {result}"))
        elif isinstance(result, Judgement):
            self._judgement = result
            self._want(self._judged_for)
        elif result is not None:
            self._try(partial(self._take, result))
        if self._wanted and not self._builder.is_busy:
            effort, self._wanted = self._wanted, ""
            self._try(partial(self._start_building, effort))
        if not self._builder.is_busy and self._answered < self._received:
            self._answered = self._received
            self._tell(Idle(self._answered, len(self._session.active)))

    def _take(self, made: WrittenMap) -> None:
        """Records a finished map and announces it."""
        replaced = self._offered - set(made.version.frames)
        if self._aligner is not None and self._graph is not None:
            poses = self._aligner.adopt(self._graph)
            self._session.frames.note_base_poses(poses)
        self._session.record(made.version, replaced)
        self._seals[made.version.version] = made.seal
        self._tell_map()

    def _start_building(self, effort: str) -> None:
        self._offered = set(self._session.active)
        frames = self._chosen_frames()
        if frames is not None and self._is_unjudged(frames.names):
            self._judged_for = effort
            self._builder.start(next_judgement(self._job, frames))
            return
        if frames is not None:
            frames = self._usable(frames)
        if frames is None:
            least = self._least_frames
            what = "a frame" if least == 1 else f"{least} frames that differ"
            self._tell(Note(f"a map needs {what}"))
            return
        camera = self._judgement.words if self._judgement else ""
        self._builder.start(
            next_map(self._job, self._session, frames, effort, camera)
        )

    def _is_unjudged(self, names: tuple[str, ...]) -> bool:
        """Returns whether frames may improve the estimate of camera errors."""
        if len(names) < LEAST_FRAMES:
            return False
        return self._judgement is None or not self._judgement.holds_for(names)

    def _chosen_frames(self) -> UsableFrames | None:
        """Returns the frames of the next map; None if there are too few.

        Damaged frames, and those with uncertain poses, are rejected.
        """
        session, frames = self._session, self._session.frames
        self._resume()
        self._refuse(frames.load(session.active))
        self._align()
        names = session.active
        poses, residual = frames.poses(names), np.full(len(names), np.nan)
        q = frames.configurations(names)
        if self._graph is not None:
            rows = self._graph.rows(self._keys(names))
            poses, residual = self._graph.X_WC[rows], self._graph.residual[rows]
            q[:, :3] = self._graph.X_WB[rows]
        kept = frames_to_keep(
            poses,
            self._job.config.max_frames,
            lambda i, j: hides_view_of(
                frames.frame(names[i]), frames.frame(names[j])
            ),
        )
        if len(kept) < self._least_frames:
            return None
        names = tuple(names[i] for i in kept)
        capture = frames.capture(names)
        if self._graph is not None:
            capture = dc.replace(capture, X_WC=poses[kept])
        objects = tuple(map(frames.objects, names))
        return UsableFrames(names, capture, q[kept], residual[kept], objects)

    def _usable(self, frames: UsableFrames) -> UsableFrames | None:
        """Returns frames that agree, with the camera's errors corrected.

        Frames with wrong poses are rejected.

        Raises:
            RemoSplatError: The frames contradict each other.
        """
        names, map_frames = frames.names, self._session.map_frames
        if judgement := self._judgement:
            if judgement.problem and judgement.holds_for(names):
                raise RemoSplatError(judgement.problem)
            capture = judgement.undone(frames.capture)
            frames = dc.replace(frames, capture=capture)
        trusted = sum(name in map_frames for name in names)
        wrong = contradicting_frames(frames.capture, trusted)
        apart = frames.residual[wrong].tolist()
        self._refuse(
            {
                names[i]: f"{names[i]} {contradiction(distance)}"
                for i, distance in zip(wrong, apart, strict=True)
            }
        )
        right = np.setdiff1d(np.arange(len(names)), wrong)
        if len(right) < self._least_frames:
            return None
        return frames.select(right)

    @property
    def _least_frames(self) -> int:
        """Returns the least number of frames; it is 1 with a base splat."""
        return MIN_VIEWS if self._job.base is None else 1

    def _align(self) -> None:
        """Aligns all frames, and rejects those with uncertain poses."""
        names = self._session.active
        if self._aligner is None or not names:
            return
        keys = self._keys(names)
        self._graph = self._aligner.align()
        vague = self._graph.covariance[self._graph.rows(keys)]
        problems = dict(zip(names, map(vagueness, vague), strict=True))
        self._refuse(
            {name: f"{name} {why}" for name, why in problems.items() if why}
        )

    def _keys(self, names: tuple[str, ...]) -> list[Key]:
        return [(name, self._session.frames.time(name)) for name in names]

    def _refuse(self, problems: dict[str, str]) -> None:
        if problems:
            if self._aligner is not None:
                self._aligner.forget(set(problems))
            self._session.refuse(set(problems))
        for problem in problems.values():
            self._tell(FrameRefused(problem))
