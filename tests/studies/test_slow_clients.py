"""The study of slow clients: a client, and the table."""

from threading import Thread

import numpy as np
import pytest
from patience import PATIENCE, wait_for

pytest.importorskip("websockets")

from apps.studies.slow_clients.__main__ import main, table_of
from apps.studies.slow_clients.client import watch
from remosplat_drake.visualization.page import MeshcatPage


def test_a_client_watches_until_the_page_has_gone():
    pages = [MeshcatPage()]
    ports = pages[0].port, pages[0].meshcat.port()
    client = Thread(target=watch, args=(*ports, 0.01), daemon=True)
    client.start()
    wait_for(lambda: pages[0].meshcat.GetNumActiveConnections() == 1)
    pages.clear()
    client.join(PATIENCE)
    assert not client.is_alive()


def test_the_table_has_the_median_of_the_ratios():
    tick, work = np.array([1e-3, 2e-3, 3e-3]), np.array([4e-3, 5e-3, 6e-3])
    runs = [
        {0: np.array([tick, work]), 2: np.array([r * tick, work])}
        for r in (1.0, 1.1, 5.0)
    ]
    rows = table_of(runs).rows
    assert [row[-1] for row in rows] == ["1.10", "1.00"]
    assert rows[0][1] == "2.00 / 3.0" and rows[1][1] == "5.00 / 6.0"


def test_a_study_without_rounds_is_refused(capsys):
    assert main(["--rounds", "0"]) == 2
    assert "--rounds: must be at least 1" in capsys.readouterr().err
