"""On which interface a page is served."""

from argparse import Namespace
from pathlib import Path

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.hold import LOCALHOST, open_page
from remosplat_drake.visualization.page import MeshcatPage

LOOPBACK = "0100007F"


def reaches_all(page: MeshcatPage) -> bool:
    """Whether the page's server listens on every interface, by Linux."""
    ports = tuple(f":{port:04X}" for port in (page.port, page.meshcat.port()))
    reached = [_reaches_all(port) for port in ports]
    assert reached[0] == reached[1]
    return reached[0]


def _reaches_all(port: str) -> bool:
    for table in ("tcp", "tcp6"):
        lines = Path("/proc/net", table).read_text().splitlines()[1:]
        for address, state in (
            (row[1], row[3]) for row in map(str.split, lines)
        ):
            if state == "0A" and address.endswith(port):
                host = address.split(":")[0]
                assert host == LOOPBACK or set(host) == {"0"}
                return host != LOOPBACK
    raise AssertionError("no server listens there")


@pytest.mark.parametrize("host, shall", [(LOCALHOST, False), ("0.0.0.0", True)])
def test_others_reach_a_page_only_if_they_shall(host, shall):
    page = open_page(Namespace(port=None, host=host))
    assert reaches_all(page) is shall


def test_no_other_computer_reaches_the_page_of_a_real_robot():
    arguments = Namespace(port=None, host="0.0.0.0", hardware=True)
    with pytest.raises(
        RemoSplatError, match="--host: with --hardware, only this"
    ):
        open_page(arguments)
