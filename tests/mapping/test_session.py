"""A session's folder: its content comes back, after any crash."""

import json
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.store.session import Session, Version

SIZE = 12, 16
SCENARIO = "robot: {model: frankie}\n"


@pytest.fixture
def session(tmp_path) -> Session:
    return Session.create(tmp_path / "session", SCENARIO)


def add(session: Session, time: float) -> str:
    """A frame of a wall that is as far away as it is late."""
    frame = Frame(
        name="the frame",
        K=np.array([[20.0, 0, 8], [0, 20, 6], [0, 0, 1]]),
        X_WC=np.eye(4),
        rgb=np.full((*SIZE, 3), 7, np.uint8),
        depth=np.full(SIZE, time, np.float32),
        hidden=np.eye(*SIZE, dtype=bool),
        time=time,
    )
    name = session.frames.add(frame, np.full(10, time))
    session.activate(name)
    return name


def record(session: Session, replaced: frozenset[str] = frozenset()) -> int:
    """A map of all active frames, without the file."""
    number = session.next_version
    file = session.map_path(number).relative_to(session.folder)
    frames = tuple(name for name in session.active if name not in replaced)
    version = Version(number, session.head, str(file), frames, 1.0)
    session.record(version, set(replaced))
    return number


def test_a_frame_comes_back(session):
    name = add(session, 1.5)
    again = Session.open(session.folder)
    assert again.active == again.frames.names == (name,) == ("frame 1",)
    assert again.frames.load(again.active) == {}
    capture = again.frames.capture(again.active)
    hidden = np.eye(*SIZE, dtype=bool)
    np.testing.assert_array_equal(capture.hidden, [hidden])
    np.testing.assert_array_equal(capture.depth, [np.where(hidden, 0, 1.5)])
    np.testing.assert_array_equal(capture.X_WC, [np.eye(4)])
    q = again.frames.configurations((name,))
    np.testing.assert_array_equal(q, [[1.5] * 10])
    assert again.frames.time(name) == 1.5


def test_maps_come_back(session):
    assert session.head_map is None
    add(session, 1.0)
    record(session)
    again = Session.open(session.folder)
    assert again.head == 1
    assert again.head_map == session.folder / "maps" / "map_0001.rsmap"
    assert again.map_frames == ("frame 1",)
    assert again.versions == session.versions


def test_undo_goes_back_to_the_parent_and_its_frames(session):
    for time in (1.0, 2.0):
        add(session, time)
        record(session)
    session.undo()
    assert (session.head, session.active) == (1, ("frame 1",))
    add(session, 3.0)
    assert record(session) == 3
    assert session.versions[3].parent == 1
    assert session.map_frames == ("frame 1", "frame 3")
    session.undo()
    session.undo()
    assert (session.head, session.active) == (0, ())
    with pytest.raises(RemoSplatError, match="nothing to undo"):
        session.undo()


def test_frames_that_are_new_are_left_out_alone(session):
    add(session, 1.0)
    record(session)
    add(session, 2.0)
    assert session.has_new_frames
    session.leave_out_new_frames()
    assert session.active == ("frame 1",)
    assert not session.has_new_frames
    # Nothing that was saved is lost.
    assert session.frames.names == ("frame 1", "frame 2")


def test_a_frame_that_came_during_the_making_counts_for_the_next_map(session):
    offered = {add(session, 1.0), add(session, 2.0)}
    add(session, 3.0)
    version = Version(1, 0, "maps/map_0001.rsmap", ("frame 2",), 1.0)
    session.record(version, offered - {"frame 2"})
    assert session.active == ("frame 2", "frame 3")
    assert session.has_new_frames


def test_a_refused_frame_is_in_no_capture(session):
    add(session, 1.0)
    wrong = add(session, 2.0)
    session.frames.load(session.active)
    session.refuse({wrong})
    assert Session.open(session.folder).frames.names == ("frame 1",)
    # Its name may come again, its pixels do not.
    name = add(session, 3.0)
    session.frames.load((name,))
    assert session.frames.capture((name,)).depth.max() == 3.0


def test_a_damaged_image_is_named_and_costs_no_other(session):
    names = add(session, 1.0), add(session, 2.0)
    image = session.folder / "frames" / "depth" / "0001.png"
    image.write_bytes(image.read_bytes()[:40])
    again = Session.open(session.folder)
    problems = again.frames.load(names)
    assert list(problems) == ["frame 1"]
    assert "0001.png" in problems["frame 1"]
    assert len(again.frames.capture(("frame 2",))) == 1


def test_a_session_is_made_in_an_empty_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RemoSplatError, match="choose a new folder"):
        Session.create(tmp_path, SCENARIO)


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"format": "remosplat session 1"}', "[" * 100_000],
)
def test_a_damaged_session_is_refused(session, text):
    path = session.folder / "session.json"
    path.write_text(text)
    with pytest.raises(RemoSplatError, match=r"session\.json"):
        Session.open(session.folder)


def refusal(session: Session, file: str, *way: str | int, value: object) -> str:
    """Why a session is not opened in whose file a value is another one."""
    path = session.folder / file
    document = json.loads(path.read_text())
    inner = document
    for key in way[:-1]:
        inner = inner[key]
    inner[way[-1]] = value
    path.write_text(json.dumps(document))
    with pytest.raises(RemoSplatError) as error:
        Session.open(session.folder)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)
    return str(error.value)


WRONG = None, True, -1, 1.5, 10**400, float("nan"), "x", [[]], {}, "\ud800"


@pytest.mark.parametrize("value", WRONG, ids=range(len(WRONG)))
@pytest.mark.parametrize(
    "way",
    [
        ("head",),
        ("active",),
        ("versions",),
        ("versions", 0),
        ("versions", 0, "version"),
        ("versions", 0, "parent"),
        ("versions", 0, "file"),
        ("versions", 0, "frames"),
    ],
)
def test_a_session_of_wrong_types_is_refused(session, way, value):
    record(session)
    assert str(way[-1]) in refusal(session, "session.json", *way, value=value)


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("file", "../../elsewhere.rsmap", "expected 'maps/map_0002.rsmap'"),
        ("parent", 2, "no previous map 2 is listed"),
        ("parent", 7, "no previous map 7 is listed"),
        ("version", 1, "1 appears twice"),
        ("seconds", -1.0, "must be at least 0"),
    ],
)
def test_maps_that_cannot_be_are_refused(session, key, value, problem):
    record(session)
    record(session)
    way = "versions", 1, key
    assert problem in refusal(session, "session.json", *way, value=value)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("name", "frame"),
        ("name", "frame 2"),
        ("name", 5),
        ("time", float("inf")),
        ("time", "now"),
        ("configuration", None),
        ("configuration", ["a"] * 10),
        ("configuration", [0.0] * 9),
    ],
)
def test_frames_that_cannot_be_are_refused(session, key, value):
    add(session, 1.0)
    add(session, 2.0)
    way = "frames", 0, key
    # The names and lengths of two frames are at odds.
    assert key in refusal(session, "frames/transforms.json", *way, value=value)


def test_one_process_writes(session):
    writer = Session.open_to_write(session.folder)
    with pytest.raises(RemoSplatError, match="is in use"):
        Session.open_to_write(session.folder)
    Session.open(session.folder)  # Reading is always allowed.
    del writer


def test_half_written_files_are_removed(session):
    maps = session.folder / "maps"
    maps.mkdir()
    half = maps / ".map_0002.rsmap.abc"
    others = [maps / "map_0001.rsmap", session.folder / ".notes.txt.swp"]
    for path in (half, *others):
        path.write_text("")
    Session.open_to_write(session.folder)
    assert not half.exists()
    assert all(Path(path).exists() for path in others)


def test_where_a_map_has_the_base_comes_back(session):
    for time in (1.0, 2.0):
        add(session, time)
    pose = np.array([0.1, -0.2, 0.3])
    session.frames.note_base_poses({"frame 2": pose, "frame 9": pose})
    again = Session.open(session.folder).frames
    assert again.base_pose("frame 1") is None
    np.testing.assert_array_equal(again.base_pose("frame 2"), pose)
    path = session.folder / "frames" / "transforms.json"
    text = path.read_text().replace("0.3\n", '"north"\n', 1)
    path.write_text(text)
    with pytest.raises(RemoSplatError, match="base_pose"):
        Session.open(session.folder)
