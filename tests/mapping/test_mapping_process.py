"""The mapping process: a real one, on the shipped table, and its accidents."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from mapped_table import (
    LARGEST,
    MISPLACED,
    SILENT,
    answers,
    looking_around,
    make_job,
    make_tilted_camera,
    table_world,
    take_frames,
    until_told,
)
from patience import PATIENCE

from remosplat_drake.app.world import World
from remosplat_drake.base.real_time import (
    CONTROLLER_PRIORITY,
    realtime_priority,
)
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.commands.main import main
from remosplat_drake.mapping.mapping_process import (
    BUSY,
    DIED,
    MOST_UNANSWERED,
    MappingProcess,
)
from remosplat_drake.mapping.messages import (
    AddFrame,
    Build,
    Building,
    FrameAdded,
    FrameRefused,
    Idle,
    MapReady,
    Note,
    Save,
    ShowScene,
    Trouble,
    Undo,
)
from remosplat_drake.mapping.store.map_file import open_map, write_map
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

DISK_FULL_FOR_FRAMES, DISK_FULL_FOR_MAPS = LARGEST


@pytest.fixture(scope="module")
def table() -> World:
    return table_world()


def of_type(events, kind) -> list:
    return [event for event in events if isinstance(event, kind)]


def stages(events) -> set[str]:
    """What maps in the making were told to be at."""
    return {event.stage for event in of_type(events, Building)}


def send_signal(process: MappingProcess, number: int) -> None:
    assert process.process is not None and process.process.pid is not None
    os.kill(process.process.pid, number)


def ask(process, *requests) -> list:
    for request in requests:
        process.request(request)
    return answers(process)


@pytest.fixture(scope="module")
def mapped(
    rendering, table, tmp_path_factory
) -> Iterator[tuple[MappingProcess, Path]]:
    """A process that has made a map of four frames, and its session."""
    folder = tmp_path_factory.mktemp("mapped") / "session"
    process = MappingProcess(make_job(table, folder))
    take_frames(process, table)
    events = ask(process, Build())
    assert [e.total for e in of_type(events, FrameAdded)] == [1, 2, 3, 4]
    assert of_type(events, MapReady)[-1].version == 1
    assert events[-1] == Idle(5, 4)
    yield process, folder
    process.close()


def test_frames_become_a_map(mapped, table):
    _, folder = mapped
    session = Session.open(folder)
    assert session.head == 1 and session.head_map is not None
    scene_map = open_map(session.head_map)
    assert scene_map.frames == ("frame 1", "frame 2", "frame 3", "frame 4")
    assert scene_map.time == 4.0
    assert scene_map.parent == 0
    spheres = table.robot.spheres_at(table.q0)
    assert np.isfinite(scene_map.field.clearances(spheres).minimum())


def test_the_frames_are_a_capture(mapped):
    _, folder = mapped
    capture = read_capture(folder / "frames")
    store = Session.open(folder).frames
    assert store.load(store.names) == {}
    ours = store.capture(store.names)
    assert len(capture) == len(ours) == len(store.names)
    np.testing.assert_array_equal(capture.depth, ours.depth)
    np.testing.assert_array_equal(capture.X_WC, ours.X_WC)


def test_reconstruct_makes_a_splat_of_the_frames(mapped, tmp_path):
    _, folder = mapped
    path = tmp_path / "splat.ply"
    arguments = [str(folder / "frames"), "-o", str(path), "--device", "none"]
    assert main(["reconstruct", *arguments, "--count", "500"]) == 0
    assert len(read_ply(path))


@pytest.mark.slow
@pytest.mark.usefixtures("rendering")
def test_a_camera_that_is_tilted_on_its_mount_is_told_and_corrected(
    table, tmp_path
):
    job = make_job(table, tmp_path / "session", make=make_tilted_camera)
    process = MappingProcess(job)
    take_frames(process, table, 10)
    events = ask(process, Build())
    assert "judging the camera" in stages(events)
    quality = open_map(of_type(events, MapReady)[-1].path).quality
    assert quality.startswith("10 frames, ")
    told = quality[quality.index("; the camera is") :]
    assert re.match(r"; the camera is (0\.9|1\.0)\d* degrees from", told)
    assert told.endswith(": corrected")
    # Frames stay as they were taken; the same ones are not judged again.
    events = ask(process, Build())
    assert stages(events) and "judging the camera" not in stages(events)
    (again,) = of_type(events, MapReady)
    assert open_map(again.path).quality.endswith(told)
    process.close()


def test_of_equal_requests_the_last_is_enough(mapped):
    process, folder = mapped
    head = Session.open(folder).head
    versions = of_type(ask(process, *[Build()] * 9), MapReady)
    assert 1 <= len(versions) < 9
    for _ in versions:
        ask(process, Undo())
    assert Session.open(folder).head == head


def test_a_silent_camera_is_told(mapped, table):
    process, _ = mapped
    events = ask(process, AddFrame(table.q0, SILENT))
    assert of_type(events, Trouble) == [
        Trouble("the wrist camera sends no images")
    ]


def test_a_frame_with_a_wrong_pose_is_refused(mapped, table):
    process, folder = mapped
    before = Session.open(folder)
    events = ask(process, AddFrame(table.q0, MISPLACED), Build())
    (refused,) = of_type(events, FrameRefused)
    assert "contradicts the other frames: its pose is wrong" in refused.reason
    after = Session.open(folder)
    assert after.active == before.active
    assert after.frames.names == before.frames.names


def test_undo_and_a_further_frame(mapped, table):
    process, folder = mapped
    head = Session.open(folder).head
    further, last = looking_around(table, 2, seed=1)
    events = ask(process, AddFrame(further, 10.0), Build())
    assert of_type(events, MapReady)[-1].version == head + 1
    events = ask(process, Undo())
    assert of_type(events, MapReady)[-1].version == head
    assert events[-1].frames == 4
    events = ask(process, AddFrame(last, 11.0), Build())
    path = of_type(events, MapReady)[-1].path
    scene_map = open_map(path)
    assert scene_map.version == head + 2 and scene_map.parent == head
    assert scene_map.frames == (
        *(f"frame {i}" for i in (1, 2, 3, 4)),
        Session.open(folder).frames.names[-1],
    )
    assert scene_map.time == 11.0
    ask(process, Undo())


@pytest.mark.usefixtures("rendering")
def test_a_map_of_another_process_is_checked_and_written_anew(table, tmp_path):
    """A control process gets the seal of what its mapping process wrote."""
    job = make_job(table, tmp_path / "session")
    session = Session.open(job.session)
    for number in (1, 2):
        record_map(session, number)
    before = session.map_path(2).stat().st_ino
    process = MappingProcess(job)
    (ready,) = of_type(until_told(process), MapReady)
    assert ready.version == 2 and session.map_path(2).stat().st_ino != before
    scene_map = open_map(ready.path, ready.seal)
    assert not scene_map.field.prepared["wide"].flags.owndata
    # What is damaged is told, and nothing has changed.
    path = session.map_path(1)
    data = bytearray(path.read_bytes())
    data[data.index(scene_map.splat_W.p_GK.tobytes())] ^= 1
    path.write_bytes(data)
    (trouble,) = of_type(ask(process, Undo()), Trouble)
    assert "the checksum of 'splat.p_GK' is wrong" in trouble.text
    assert Session.open(job.session).head == 2
    process.close()


def record_map(session: Session, number: int) -> None:
    """Notes a map of one disc, as another process has left it."""
    splat_W = GaussianSplat(
        p_GK=np.array([[1.0, 2.0, 3.0]]),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.full((1, 2), 0.01),
        opacities=np.ones(1),
        colors=np.ones((1, 3)),
    )
    field = SphereToEllipsoidField(splat_W)
    path = session.map_path(number)
    write_map(path, SceneMap(number, number - 1, (), 0.0, field, splat_W))
    file = str(path.relative_to(session.folder))
    session.record(Version(number, number - 1, file, (), 1.0), set())


def test_frames_that_no_map_has_are_undone_first(mapped, table):
    process, folder = mapped
    head = Session.open(folder).head
    (q,) = looking_around(table, 1, seed=2)
    events = ask(process, AddFrame(q, 20.0), Undo())
    assert of_type(events, Note)
    assert events[-1].frames == 4
    assert Session.open(folder).head == head


def test_the_splat_is_saved_for_others(mapped):
    process, folder = mapped
    (note,) = of_type(ask(process, Save()), Note)
    assert note.text == f"saved {folder / 'splat.ply'}"
    assert len(read_ply(folder / "splat.ply"))


def test_ctrl_c_is_not_for_this_process(mapped):
    process, _ = mapped
    for _ in range(2):
        send_signal(process, signal.SIGINT)
    assert isinstance(ask(process, ShowScene(PrimitiveScene()))[-1], Idle)


def test_a_disk_too_full_for_a_frame_is_told(mapped, table):
    process, folder = mapped
    before = Session.open(folder)
    frame, build = AddFrame(table.q0, DISK_FULL_FOR_FRAMES), Build()
    events = ask(process, frame)
    (trouble,) = of_type(events, Trouble)
    assert "cannot be written" in trouble.text
    after = Session.open(folder)
    assert after.frames.names == before.frames.names
    assert after.active == before.active
    check_tidy(folder)
    # A caller that makes room can go on.
    events = ask(process, AddFrame(table.q0, 30.0), build)
    assert of_type(events, MapReady)[-1].version > before.head
    ask(process, Undo())


def test_a_disk_too_full_for_a_map_is_told(mapped, table):
    process, folder = mapped
    before = Session.open(folder)
    (q,) = looking_around(table, 1, seed=3)
    events = ask(process, AddFrame(q, DISK_FULL_FOR_MAPS), Build())
    assert of_type(events, FrameAdded)
    (trouble,) = of_type(events, Trouble)
    assert "cannot be written" in trouble.text
    after = Session.open(folder)
    assert after.head == before.head
    assert len(after.active) == len(before.active) + 1
    check_tidy(folder)
    ask(process, Undo())


def check_tidy(folder: Path) -> None:
    """What no file could hold has left nothing behind."""
    assert not [p for p in folder.rglob(".*") if p.is_file()]


def test_killed_it_goes_on_where_it_was(mapped, table):
    process, folder = mapped
    before = Session.open(folder)
    send_signal(process, signal.SIGKILL)
    assert until_told(process) == [Trouble(DIED), Idle(process.sent)]
    (q,) = looking_around(table, 1, seed=1)
    with realtime_priority(CONTROLLER_PRIORITY):
        process.request(AddFrame(q, 40.0))
        process.request(Build())
        while process.process is None:
            time.sleep(0.001)
    send_signal(process, signal.SIGINT)  # While it is only starting.
    # A loop that goes first does not take it along.
    assert process.process.pid is not None
    assert os.sched_getscheduler(process.process.pid) == os.SCHED_OTHER
    events = answers(process)
    (added,) = of_type(events, FrameAdded)
    assert added.total == len(before.active) + 1
    versions = [event.version for event in of_type(events, MapReady)]
    assert versions == [before.head, before.next_version]
    ask(process, Undo())


@pytest.mark.slow
def test_killed_while_it_works_it_loses_only_that(mapped):
    process, folder = mapped
    before = Session.open(folder)
    process.request(Build("full"))
    process.poll()
    send_signal(process, signal.SIGKILL)
    events = until_told(process)
    while Trouble(DIED) not in events:
        events += until_told(process)
    assert process.answered == process.sent
    events = ask(process, Build())
    assert of_type(events, MapReady)[-1].version == before.next_version
    assert Session.open(folder).active == before.active


@pytest.mark.slow
def test_it_ends_with_its_parent(table, tmp_path):
    program = (
        "import os, sys, time; sys.path[:0] = sys.argv[2:];"
        "from pathlib import Path; from mapped_table import *;"
        "job = make_job(table_world(), Path(sys.argv[1]));"
        "process = MappingProcess(job);"
        "until_told(process); print(process.process.pid, flush=True);"
        "os.kill(os.getpid(), 9)"
    )
    answer = subprocess.run(
        [
            sys.executable,
            "-c",
            program,
            str(tmp_path / "session"),
            str(Path(__file__).parent),
            str(Path(__file__).parents[1]),
        ],
        capture_output=True,
        text=True,
    )
    pid = int(answer.stdout)
    end = time.monotonic() + PATIENCE
    # Of a process with an exit code that was not fetched the line is empty.
    while command_line(pid):
        assert time.monotonic() < end, "it lives on"
        time.sleep(0.05)


def command_line(pid: int) -> bytes:
    """What started a process; empty if it has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def test_too_many_requests_are_dropped(mapped):
    process, _ = mapped
    sent = process.sent
    for _ in range(MOST_UNANSWERED + 2):
        process.request(Undo())
    assert process.sent == sent + MOST_UNANSWERED
    events = answers(process)
    assert of_type(events, Trouble).count(Trouble(BUSY)) == 2
    undone = len(of_type(events, MapReady))
    refused = events.count(Trouble("there is nothing to undo"))
    assert undone + refused == MOST_UNANSWERED


def test_what_cannot_start_says_why(table, tmp_path):
    job = make_job(table, tmp_path / "session")
    (tmp_path / "session" / "session.json").write_text("{}")
    process = MappingProcess(job)
    events = ask(process, Build())
    assert "session.json" in of_type(events, Trouble)[0].text
    process.close()
