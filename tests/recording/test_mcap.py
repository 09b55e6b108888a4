"""MCAP files, written by the recording process and read by the mcap library."""

import json
import os
import re
import resource
import signal
import subprocess
import time
from base64 import b64decode
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from textwrap import indent

import jsonschema
import numpy as np
import pytest
from consenting import consenting
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, robot_process, running
from runs import PATIENT, command_line, remosplat
from ticks import tick

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.commands.driving import INCOMPLETE
from remosplat_drake.hardware.hardware_config import HardwareConfig, beside
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA
from remosplat_drake.hardware.wire.images import encode_images
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.recording.events import SUPERVISOR, Event
from remosplat_drake.recording.mcap import mcap_recorder
from remosplat_drake.recording.mcap.mcap_file import McapFile, partial_path
from remosplat_drake.recording.mcap.mcap_recorder import McapRecorder
from remosplat_drake.recording.mcap.messages import Message, stamp

reader = pytest.importorskip("mcap.reader")
pictures = pytest.importorskip("PIL.Image")


KITCHEN = """
Kitchen:
  scene:
    splat: package://remosplat_drake/models/scenes/table/splat.ply
    truth: package://remosplat_drake/models/scenes/table/scene.json
  wrist_camera: {{width: 64, height: 48}}
{patient}
"""
"""The default scenario, with a camera that is quickly rendered."""


def messages(path: Path) -> dict[str, list[dict]]:
    """All messages of a file by topic, each of them valid by its schema.

    It is read from the front, as a file without an index has to be.
    """
    found, validators = defaultdict(list), {}
    with path.open("rb") as file:
        try:
            for schema, channel, message in reader.NonSeekingReader(
                file, validate_crcs=True
            ).iter_messages(log_time_order=False):
                content = json.loads(message.data)
                if schema.id not in validators:
                    definition = json.loads(schema.data)
                    jsonschema.Draft202012Validator.check_schema(definition)
                    validators[schema.id] = jsonschema.Draft202012Validator(
                        definition
                    )
                validators[schema.id].validate(content)
                found[channel.topic].append(content)
        except reader.McapError:
            pass  # Its writer was killed.
    return found


def test_ticks_become_valid_messages(frankie, tmp_path):
    path = tmp_path / "a.mcap"
    recorder = McapRecorder(path, frankie)
    recorder.append(tick(frankie, 100.0, Event(100.0, SUPERVISOR, "stopped")))
    recorder.append(tick(frankie, 100.01))
    recorder.close()
    assert recorder.trouble == ""
    found = messages(path)
    assert [m["timestamp"]["nsec"] for m in found["/command"]] == [
        0,
        10_000_000,
    ]
    links = found["/clearances"][0]["links"]
    assert links[frankie.spheres.links[3]] == 0.1
    assert found["/clearances"][0]["minimum"] == 0.1
    assert found["/events"][0]["message"] == "stopped"
    joints = found["/joint_states"][0]["joints"]
    assert [j["name"] for j in joints] == list(frankie.description.arm.joints)
    # Two ticks within a thirtieth of a second have one set of transforms.
    (transforms,) = (m["transforms"] for m in found["/tf"])
    X_WL = frankie.body_poses(frankie.q_home)
    by_name = {t["child_frame_id"]: t["translation"] for t in transforms}
    hand = by_name["panda_link7"]
    np.testing.assert_allclose(
        [hand[axis] for axis in "xyz"],
        X_WL[frankie.tree.index("panda_link7"), :3, 3],
    )
    assert "target" in by_name
    with path.open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    assert {s.encoding for s in summary.schemas.values()} == {"jsonschema"}
    assert {c.message_encoding for c in summary.channels.values()} == {"json"}


def test_images_on_the_cameras_wire_are_recorded(frankie, tmp_path):
    path, url = tmp_path / "a.mcap", free_url()
    recorder = McapRecorder(path, frankie, camera=HardwareConfig(lcm_url=url))
    lcm = DrakeLcm(beside(url))
    rgb = np.full((24, 32, 3), 100, np.uint8)
    depth = np.full((24, 32), 1.5, np.float32)
    end, n = time.monotonic() + PATIENCE, 0
    partial = partial_path(path)
    while "/wrist_camera/depth" not in (found := messages(partial)):
        assert time.monotonic() < end
        n += 1
        lcm.Publish(WRIST_CAMERA, b"nonsense")
        time.sleep(0.1)  # Drake keeps one message until it is fetched.
        lcm.Publish(WRIST_CAMERA, encode_images(rgb, depth, 10**6 * n))
        time.sleep(0.1)
    recorder.close()
    complaints = [message["message"] for message in found["/events"]]
    assert complaints == ["WRIST_CAMERA: is not a whole lcmt_image_array"]
    message = found["/wrist_camera/depth"][0]
    steps = np.asarray(pictures.open(BytesIO(b64decode(message["data"]))))
    np.testing.assert_array_equal(steps, np.full((24, 32), 1500))
    message = found["/wrist_camera/color"][0]
    colors = np.asarray(pictures.open(BytesIO(b64decode(message["data"]))))
    np.testing.assert_allclose(colors, rgb, atol=3)


def test_a_stalled_process_delays_no_tick(frankie, tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_recorder, "WAITING", 5)
    monkeypatch.setattr(mcap_recorder, "_BUFFER", 1 << 16)
    path = tmp_path / "a.mcap"
    recorder = McapRecorder(path, frankie)
    process = recorder._child.process
    assert process is not None and process.pid is not None
    os.kill(process.pid, signal.SIGSTOP)
    slowest, count = 0.0, 0
    while recorder.left_out < 3:
        count += 1
        start = time.thread_time()
        recorder.append(tick(frankie, 100.0 + 0.01 * count))
        slowest = max(slowest, time.thread_time() - start)
    assert slowest < 0.1
    assert (
        recorder.trouble
        == "the recording lacks 3 ticks, since its process is too slow"
    )
    os.kill(process.pid, signal.SIGCONT)
    recorder.close()
    assert (
        recorder.trouble
        == "the recording lacks 3 ticks, since its process is too slow"
    )
    assert len(messages(path)["/command"]) == count - 3


def test_a_killed_process_is_told(frankie, tmp_path):
    path = tmp_path / "a.mcap"
    recorder = McapRecorder(path, frankie)
    process = recorder._child.process
    assert process is not None
    process.kill()
    process.join()
    recorder.append(tick(frankie, 100.0))
    assert "the recording has ended" in recorder.trouble
    recorder.close()
    assert not path.exists() and partial_path(path).exists()


def test_a_process_that_is_killed_at_the_end_is_told(frankie, tmp_path):
    path = tmp_path / "a.mcap"
    recorder = McapRecorder(path, frankie)
    process = recorder._child.process
    assert process is not None
    process.kill()
    process.join()
    recorder.close()
    assert recorder.trouble.startswith(
        "the recording has ended: the file is incomplete; "
    )


def test_a_full_file_gets_no_more(tmp_path):
    file = McapFile(tmp_path / "a.mcap", limit=1 << 20)
    content = {
        "timestamp": stamp(1.0),
        "frame_id": "c",
        "data": "",
        "format": "png",
    }
    rng = np.random.default_rng(0)
    while not file.trouble:
        content["data"] = rng.bytes(50_000).hex()
        file.add(Message("/x", "foxglove.CompressedImage", dict(content)))
        file.flush(at_once=True)
    assert file.trouble == "the file exceeds 1 MiB"
    path = tmp_path / "a.partial.mcap"
    size = path.stat().st_size
    assert (1 << 20) < size < (1 << 20) + 100_000
    file.add(Message("/x", "foxglove.CompressedImage", content))
    file.close()
    assert path.stat().st_size < size + 10_000
    with path.open("rb") as file:
        assert reader.make_reader(file).get_summary() is not None
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """No file of this process grows beyond a size meanwhile [bytes]."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_file_that_cannot_be_begun_leaves_nothing(tmp_path):
    with full_disk(10), pytest.raises(FileError, match=r"a\.mcap: cannot be"):
        McapFile(tmp_path / "a.mcap", limit=1 << 20)
    assert not list(tmp_path.iterdir())


def test_what_was_written_before_the_disk_was_full_is_whole(tmp_path):
    file = McapFile(tmp_path / "a.mcap", limit=1 << 20)
    content = {"timestamp": stamp(1.0), "level": 2, "message": "it goes on"}
    content |= {"name": "test", "file": "", "line": 0}
    message = Message("/events", "foxglove.Log", content)
    file.add(message)
    file.flush(at_once=True)
    size = partial_path(tmp_path / "a.mcap").stat().st_size
    with full_disk(size + 50):
        file.add(message)
        file.flush(at_once=True)
        assert file.trouble == "File too large"
        file.close()
    assert [p.name for p in tmp_path.iterdir()] == ["a.partial.mcap"]
    assert partial_path(tmp_path / "a.mcap").stat().st_size == size
    found = messages(partial_path(tmp_path / "a.mcap"))
    assert found["/events"] == [content]


@pytest.mark.parametrize("name", ["a.mcap", "a.partial.mcap"])
def test_an_existing_file_is_not_overwritten(frankie, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"mine")
    with pytest.raises(RemoSplatError, match=f"--record: .*{name}: File exist"):
        McapRecorder(tmp_path / "a.mcap", frankie)
    assert path.read_bytes() == b"mine"
    assert [p.name for p in tmp_path.iterdir()] == [name]


FULL = 60_000
"""Size at which the disk of these tests is full [bytes]."""


def test_a_recording_on_a_full_disk_is_not_called_whole(tmp_path):
    """Where nothing else is wrong, the robot gets there and the run fails."""
    done = remosplat(
        *("run", "TableGroundTruth", "--headless"),
        *("--record", tmp_path / "a.mcap", "--output", tmp_path / "run"),
        largest_file=FULL,
    )
    assert done.returncode == INCOMPLETE, done.stderr
    *_, last = done.stderr.splitlines()
    assert last == (
        f"the recording has ended: File too large; {tmp_path}/a.partial.mcap"
        " contains what was written before"
    )
    assert {p.name for p in tmp_path.iterdir()} == {"a.partial.mcap", "run"}
    assert len(list((tmp_path / "run").iterdir())) == 2


@pytest.mark.slow
def test_a_full_disk_is_told_at_once_and_at_the_end(tmp_path):
    """The robot goes on; at a tenth of real time it takes long enough."""
    done = remosplat(
        *("run", "TableGroundTruth", "--headless", "--realtime-rate", "0.1"),
        *("--record", tmp_path / "a.mcap"),
        largest_file=FULL,
    )
    assert done.returncode == INCOMPLETE, done.stderr
    assert re.search(r"^outcome +reached", done.stdout, re.M), done.stdout
    lines = done.stderr.splitlines()
    told = [i for i, x in enumerate(lines) if "File too large" in x]
    assert len(told) == 2 and told[0] < told[1] == len(lines) - 1
    # Its beginning can be read.
    assert messages(tmp_path / "a.partial.mcap")["/command"]


def test_a_run_is_recorded_whole(tmp_path):
    path = tmp_path / "a.mcap"
    done = remosplat(
        "run",
        "TableGroundTruth",
        "--headless",
        "--record",
        path,
        "--output",
        tmp_path,
    )
    assert done.returncode == 0, done.stderr
    ticks = json.loads((tmp_path / "metrics.json").read_text())["ticks"]
    found = messages(path)
    assert len(found["/command"]) == ticks
    assert len(found["/station_status"]) == ticks


@pytest.mark.slow
def test_a_robot_on_the_wire_is_recorded_with_its_camera(
    lone_robot, rendering, tmp_path
):
    """Robot, camera, controller and recorder, each a process of its own."""
    scenario = tmp_path / "kitchen.yaml"
    scenario.write_text(KITCHEN.format(patient=indent(PATIENT, "  ")))
    url, path = free_url(), tmp_path / "a.mcap"
    wire = "--lcm-url", url
    with (
        robot_process(url, str(scenario)),
        running("camera-sim", str(scenario), *wire, "--rate", "10"),
        consenting(url),
    ):
        images = Inbox(DrakeLcm(beside(url)), [WRIST_CAMERA])
        client = Client(url)
        client.wait_for_robot()
        client.wait_for(lambda: any(images.fetch()))
        done = remosplat(
            *("run", scenario, "--hardware", "--without-doctor", "--headless"),
            *(*wire, "--record", path, "--output", tmp_path),
        )
    assert done.returncode == 0, done.stderr
    ticks = json.loads((tmp_path / "metrics.json").read_text())["ticks"]
    found = messages(path)
    for topic in "/command", "/station_status", "/supervision":
        # Where a tick was late, one of the two recorders may have missed it.
        assert ticks - 5 <= len(found[topic]) <= ticks, topic
    stamps = [image["timestamp"] for image in found["/wrist_camera/depth"]]
    assert len(found["/wrist_camera/color"]) == len(stamps) > 1
    assert len({str(stamp) for stamp in stamps}) == len(stamps)


@pytest.mark.slow
def test_a_full_disk_does_not_stop_a_robot(lone_robot, tmp_path):
    """It reaches its target, and the program says what is lacking."""
    url, path = free_url(), tmp_path / "a.mcap"
    with robot_process(url, "TableReach"), consenting(url):
        Client(url).wait_for_robot()
        done = remosplat(
            *("run", "TableReach", "--hardware", "--without-doctor"),
            *("--headless", "--lcm-url", url, "--record", path),
            *("--scenario-text", PATIENT),
            largest_file=FULL,
        )
    assert done.returncode == INCOMPLETE, done.stderr
    assert re.search(r"^outcome +reached", done.stdout, re.M), done.stdout
    assert "File too large" in done.stderr.splitlines()[-1]
    assert not path.exists() and partial_path(path).exists()


@pytest.mark.slow
def test_the_recording_outlives_the_run(tmp_path):
    """Kill -9 in the middle: what was seen before can be read."""
    path = tmp_path / "a.mcap"
    line = command_line(
        "run",
        "TableReach",
        "--headless",
        "--realtime-rate",
        "0.2",
        "--record",
        path,
    )
    with subprocess.Popen(
        line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as run:
        end = time.monotonic() + PATIENCE
        partial = partial_path(path)
        while not partial.exists() or len(messages(partial)["/command"]) < 30:
            assert run.poll() is None and time.monotonic() < end
            time.sleep(0.2)
        before = len(messages(partial)["/command"])
        run.kill()
    while not path.exists():  # The recording process comes to its end.
        assert time.monotonic() < end
        time.sleep(0.2)
    with path.open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    counts = summary.statistics.channel_message_counts
    topics = {c.topic: n for n, c in summary.channels.items()}
    assert counts[topics["/command"]] >= before
