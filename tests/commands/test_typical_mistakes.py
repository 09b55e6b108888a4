"""Typical mistakes at the command line, and the one line about each."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from remosplat_drake.commands.main import USER_ERROR, main

MESH = """ply
format ascii 1.0
element vertex 1
property float x
property float y
property float z
end_header
0 0 0
"""

MISTAKES = {
    "rnu TableReach": "unknown command 'rnu' (did you mean 'run'?); valid: ",
    "run TabelReach": "unknown scenario 'TabelReach' (did you mean"
    " 'TableReach'?); valid: TableReach, BookshelfReach,",
    "run kitchn.yaml": "kitchn.yaml: no such file (did you mean"
    " 'kitchen.yaml'?)",
    "run kitchen.yaml:Kichen": "kitchen.yaml: unknown scenario 'Kichen' (did"
    " you mean 'Kitchen'?); valid: Kitchen",
    "run photos": "photos: is a folder, and neither a scenario (.yaml, .yml)"
    " nor a splat (a folder without meta.json is not an SOG)",
    "run mesh.ply": "mesh.ply: is not a Gaussian splat: property",
    "run TableReach --headless --recrod a.mcap": "run: unknown flag"
    " '--recrod' (did you mean '--record'?); valid: --record,",
    "convert a.ply b.ply --headless": "convert: unknown flag '--headless' (a"
    " flag of run, teleop); valid: ",
    "run TableReach --realtime-rate -1": "run: --realtime-rate: -1 is not a"
    " number >= 0",
    "run TableReach --headless --output full": "full/metrics.json:",
    "run --scenario-text {time_limt:0}": "--scenario-text:1: time_limt:0:"
    " unknown field 'time_limt:0' (did you mean 'time_limit'?); valid:",
    "run --scenario-text {controler:{}}": "--scenario-text:1: controler:"
    " unknown field 'controler' (did you mean 'controller'?); valid: ",
    "run TableReach --port PORT": "--port PORT is taken on localhost: choose"
    " another one, or leave the flag out",
    "inspect TableReach --page --port PORT": "--port PORT is taken on",
    "teleop TableTeleop --port PORT": "--port PORT is taken on 127.0.0.1",
    "teleop TableTeleop --viewer meshcat --port PORT": "--port PORT is taken",
    "teleop TableTeleop --host 192.0.2.1": "--host 192.0.2.1: Cannot assign",
    "run TableReach --port 80": "run: --port: 80 is not 1024 to 65535",
    "teleop --viewer meshcat --host 0.0.0.0": "--host: needs the cockpit, in"
    " which only a client with the operator's code moves the robot; leave out",
    "teleop --viewer mescat": "teleop: --viewer: unknown choice 'mescat' (did"
    " you mean 'meshcat'?); valid: cockpit, meshcat",
    "bench tik": "bench: group: unknown choice 'tik' (did you mean 'tick'?);",
    "benchmark --methods sdf-gided": "--methods: unknown method 'sdf-gided'"
    " (did you mean 'sdf-guided'?); valid:",
}
"""How the line after `remosplat: ` begins, by command."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "kitchen.yaml").write_text("Kitchen:\n  time_limit: 5\n")
    (tmp_path / "mesh.ply").write_text(MESH)
    (tmp_path / "photos").mkdir()
    (tmp_path / "full").write_text("no folder")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def port() -> Iterator[str]:
    """A port at which another program listens."""
    with socket.socket() as other:
        other.bind(("localhost", 0))
        other.listen()
        yield str(other.getsockname()[1])


@pytest.mark.parametrize("command", MISTAKES)
def test_it_is_one_line_that_helps(command, folder, port, capfd):
    before = sorted(folder.rglob("*"))
    words = command.replace("PORT", port).split()
    assert main(words) == USER_ERROR
    captured = capfd.readouterr()
    assert captured.out == ""
    *news, line = captured.err.replace(f"{folder}/", "").splitlines()
    expected = MISTAKES[command].replace("PORT", port)
    assert line.startswith(f"remosplat: {expected}")
    # Nothing but what the map is like may have been said before.
    assert not any("usage" in x or "Traceback" in x for x in news)
    # Nothing is left half-written.
    assert sorted(folder.rglob("*")) == before
