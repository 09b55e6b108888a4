"""`remosplat run` and its page, from START to the end, as people see it."""

import json
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, find_chromium, open_browser
from patience import PATIENCE
from runs import command_line

SIZES = (1280, 800), (390, 844), (844, 390)
"""A screen, and a telephone both ways [px]."""

BOXES = """(() => {
  const box = (e) => {
    const r = e.getBoundingClientRect();
    return [r.left, r.top, r.right, r.bottom];
  };
  const row = (name) =>
    document.querySelector(`.dg li:has(.remosplat-${name})`);
  const scene = document.querySelector('#meshcat-pane');
  const [left, top, right, bottom] = box(scene);
  const covered = [];
  for (let i = 1; i < 20; ++i) for (let j = 1; j < 20; ++j) {
    const x = left + (i / 20) * (right - left);
    const y = top + (j / 20) * (bottom - top);
    if (!scene.contains(document.elementFromPoint(x, y))) covered.push([x, y]);
  }
  const buttons = {};
  for (const name of ['start', 'stop', 'release']) {
    const e = row(name);
    if (!e?.offsetHeight) continue;
    const [x0, y0, x1, y1] = box(e);
    const there = document.elementFromPoint((x0 + x1) / 2, (y0 + y1) / 2);
    buttons[name] = { box: [x0, y0, x1, y1], free: e.contains(there) };
  }
  return {
    window: [innerWidth, innerHeight, document.documentElement.scrollWidth],
    bar: box(document.querySelector('#bar')), scene: box(scene), covered,
    buttons, panel: box(document.querySelector('#panel')),
  };
})()"""
"""Where everything is on the page [px]."""

HAND = (
    "viewer.scene_tree.find(['remosplat', 'robot', 'hand', 'panda_hand'])"
    ".object.position.toArray()"
)


@pytest.fixture
def port() -> int:
    """A port that was free a moment ago."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


@contextmanager
def waiting_run(port: int, output: Path) -> Iterator[subprocess.Popen[str]]:
    """A run that waits at its page, slow enough to be looked at."""
    with subprocess.Popen(
        command_line(
            *("run", "TableReach", "--wait-for-viewer", "--hold"),
            # Slow enough to be stopped.
            *("--scenario-text", "{controller: {gains: tuned}}"),
            *("--realtime-rate", "0.2", "--port", str(port)),
            *("--output", output),
        ),
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def address(process: subprocess.Popen[str]) -> str:
    """Where the process says that its page is."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("watch at"):
            return line.split()[2]
    raise AssertionError("the process has gone")


def wait_until_said(tab: Browser, *words: str):
    """Waits until the bar says something."""
    bar = "document.querySelector('#bar')"
    for word in words:
        said = f"{bar}?.innerText.includes({json.dumps(word)})"
        tab.wait_for(f"!!{said}")


def overlap(a: list[float], b: list[float]) -> bool:
    """Whether two boxes share more than an edge."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return width > 1 and height > 1


def check_layout(tab: Browser, *buttons: str):
    """Nothing covers the scene; what can be pressed is large and in sight."""
    for button in buttons:
        tab.wait_for(f"!!document.querySelector('.remosplat-{button}')")
    for width, height in SIZES:
        tab.show_as(width, height, mobile=width < 1000)
        tab.wait_for(f"innerWidth == {width} && innerHeight == {height}")
        at = tab.evaluate(BOXES)
        assert at["window"] == [width, height, width]
        assert at["bar"][:3] == [0, 0, width]
        assert at["covered"] == []
        for part in (at["bar"], at["panel"]):
            assert not overlap(at["scene"], part), at
        left, top, right, bottom = at["scene"]
        assert (right - left) * (bottom - top) > 0.4 * width * height
        assert set(at["buttons"]) == set(buttons)
        for button in at["buttons"].values():
            x0, y0, x1, y1 = button["box"]
            assert button["free"] and x0 >= 0 and y0 >= 0
            assert x1 <= width and y1 <= height
            # No thumb misses it.
            assert x1 - x0 > 100 and y1 - y0 >= 36


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_run_is_started_stopped_released_and_ends(port, tmp_path):
    with (
        waiting_run(port, tmp_path) as process,
        open_browser((1280, 900)) as tab,
    ):
        url = address(process)
        assert url == f"http://localhost:{port}"
        tab.draw_nothing()
        tab.listen_to_console()
        tab.open(url)
        wait_until_said(
            tab, "Ready", "reach 0.", "mm from the", "wrong by up to"
        )
        tab.wait_for(f"!!{HAND}")
        check_layout(tab, "start")
        before = np.array(tab.evaluate(HAND))
        tab.click(".remosplat-start")
        wait_until_said(tab, "Live", "moving to the target")
        check_layout(tab, "stop")
        tab.press("Escape")
        wait_until_said(tab, "Stopped", "stop button")
        check_layout(tab, "stop", "release")
        tab.click(".remosplat-release")
        wait_until_said(tab, "Reached")
        check_layout(tab)
        after = np.array(tab.evaluate(HAND))
        assert np.linalg.norm(after - before) > 0.2
        # What has ended can be played again, and nothing else.
        for control in ("time", "play"):
            tab.wait_for(f"document.querySelector('#{control}').offsetHeight")
        assert tab.console() == []
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert metrics["outcome"] == "reached"
