"""A page as one file: what it carries, and what it tells."""

import base64
import json
import struct
import zlib

import numpy as np
import pytest
from browser import open_browser
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from screenshot import find_chromium

from remosplat_drake.visualization.page_state import ended
from remosplat_drake.visualization.saved_page.account import (
    Account,
    Moment,
    thinned,
)
from remosplat_drake.visualization.saved_page.archive import compressed, pack


def make_account(time, q, clearance=None, **arguments) -> Account:
    if clearance is None:
        clearance = np.full(len(time), np.inf)
    return Account(
        state=ended("in 10.0 s", reached=True),
        time=np.asarray(time, float),
        q=np.asarray(q, float).reshape(len(time), -1),
        clearance=clearance,
        stopping=0.02,
        influence=0.5,
        **arguments,
    )


def opened(data: bytes) -> list[bytes]:
    """The parts of an archive, put together again."""
    data = zlib.decompress(data)
    (size,) = struct.unpack("<I", data[:4])
    at, parts = 4 + size, []
    for length, stride in json.loads(data[4:at]):
        part, at = data[at : at + length], at + length
        rows = length // stride
        whole = bytearray(part)
        for k in range(stride):
            whole[k : rows * stride : stride] = part[k * rows : (k + 1) * rows]
        parts.append(bytes(whole))
    return parts


@settings(max_examples=50)
@given(st.lists(st.binary(max_size=50)))
def test_nothing_is_lost_in_an_archive(parts):
    assert opened(compressed(parts)) == parts


def test_floats_are_sorted_by_their_bytes():
    data = np.linspace(0, 1, 10_000, dtype=np.float32).tobytes()
    assert len(compressed([data])) < 0.6 * len(zlib.compress(data, 9))


def test_no_path_of_the_computer_is_in_the_file():
    page = (
        "<script>\n// buffers[0] from /home/someone/mesh.gltf\n"
        'casAssets["a"] = "data:application/octet-binary;base64,AAEC";\n'
    )
    text = pack(page, "run").split('"text/plain">')[1].split("<")[0]
    html, asset = opened(base64.b64decode(text))
    assert asset == b"\x00\x01\x02"
    assert html == b'<script>\ncasAssets["a"] = remosplat.url(1);\n'


def test_a_wait_at_the_start_is_passed_over():
    """Still for 50 s, then it moves for a second."""
    time = np.arange(0, 51, 0.5)
    dut = make_account(time, np.clip(time - 50, 0, None))
    assert dut.begin == pytest.approx(49.5)
    assert dut.idle() == [(0.0, 49.5)]


def test_what_stands_still_in_between_is_passed_over():
    time = np.arange(0, 20, 0.5)
    q = np.clip(time, 0, 2) + np.clip(time - 12, 0, 2)
    dut = make_account(time, q)
    assert dut.begin == 0.0
    (first, last) = dut.idle()
    np.testing.assert_allclose(first, (2.0, 11.5))
    assert last[0] == pytest.approx(14.0)


def test_a_run_that_never_moves_is_shown_from_its_start():
    dut = make_account([0, 10, 20], [1, 1, 1])
    assert dut.begin == 0.0 and dut.idle() == []


def test_the_nearest_moment_is_told():
    clearance = np.array([np.inf, 0.05, np.nan, 0.02])
    moment = make_account(range(4), range(4), clearance).closest()
    assert moment == Moment(3.0, "nearest to the scene: 20 mm")
    assert make_account(range(4), range(4)).closest() is None


def test_thinning_keeps_the_worst():
    value = np.ones(1000)
    value[[123, 500]] = 0.1, np.nan
    time, few = thinned(np.arange(1000.0), value, np.nanmin, most=100)
    assert len(time) == len(few) == 100
    assert few.min() == 0.1 and not np.isnan(few).any()


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_browser_plays_a_saved_page(page, tmp_path):
    """One time line for scene, plot and events, and nothing in the console."""
    thing = "/remosplat/thing"
    page.meshcat.SetObject(thing, Box(0.2, 0.2, 0.2))
    page.start_recording()
    time = np.arange(0, 10.1, 0.1)
    for t in time:
        X = RigidTransform([0.1 * max(0.0, t - 8), 0, 0.5])
        page.meshcat.SetTransform(thing, X, time_in_recording=t)
    page.finish_recording()
    clearance = 0.3 - 0.02 * time
    account = make_account(
        time,
        np.clip(time - 8, 0, None),
        clearance,
        moments=[Moment(9.0, "an <event>")],
        facts=[("path", "0.2 m")],
    )
    page.set_badge("good", "Map good", "")
    page.save_html(tmp_path / "run.html", account)
    with open_browser((1280, 900)) as tab:
        tab.draw_nothing()
        tab.listen_to_console()
        tab.open((tmp_path / "run.html").resolve().as_uri())
        clock = "parseFloat(document.querySelector('#clock')?.textContent)"
        # It begins before the first motion, and ends where the run did.
        assert tab.wait_for(clock) >= 7.4
        tab.wait_for(f"{clock} == 10")
        text = tab.evaluate("document.body.innerText")
        for told in ("Reached", "in 10.0 s", "Map good", "0.2 m", "an <event>"):
            assert told in text
        # The clock rounds: what it shows as the end is the end.
        tab.evaluate(
            "const slider = document.querySelector('#time');"
            "slider.value = 9.96; slider.dispatchEvent(new Event('input'))"
        )
        assert tab.evaluate(clock) == 10.0
        assert "Reached" in tab.evaluate("document.body.innerText")
        tab.evaluate("document.querySelector('#events button').click()")
        assert tab.evaluate(clock) == 9.0
        x = "viewer.scene_tree.find(['remosplat', 'thing']).object.position.x"
        assert tab.evaluate(x) == pytest.approx(0.1, abs=0.02)
        line = (
            "parseFloat(document.querySelector('.cursor').getAttribute('x1'))"
        )
        assert tab.evaluate(line) == pytest.approx(46 + 0.9 * 320, abs=2)
        for size in ((1280, 800), (390, 844), (844, 390)):
            tab.show_as(*size)
            wide = tab.evaluate("scrollX + document.body.scrollWidth")
            assert wide <= size[0]
        assert tab.console() == []
