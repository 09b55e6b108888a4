"""An operator is told that the disk is full."""

import subprocess
import sys
from pathlib import Path

# A process to which the disk is full after two seconds of a log, and that
# goes on for one more.
_PROGRAM = """
import resource, sys
from pathlib import Path
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from test_trajectory_recorder import PERIOD, Ticks
from remosplat_drake.recording.run_log import row_type
from remosplat_drake.recording.trajectory_log import LOG, TrajectoryLog
from remosplat_drake.visualization.log_view import LogView
from remosplat_drake.visualization.page import MeshcatPage

folder, page = Path(sys.argv[1]), MeshcatPage()
builder = DiagramBuilder()
ticks = builder.AddSystem(Ticks())
log = TrajectoryLog.AddToBuilder(
    builder,
    inputs={"report": ticks.GetOutputPort("report")},
    folder=folder,
    n_q=1,
    n_u=1,
    period=PERIOD,
)
LogView.AddToBuilder(builder, page=page, trouble=log.GetOutputPort("trouble"))
full = (folder / LOG).stat().st_size + 20 * row_type(1, 1).itemsize
resource.setrlimit(resource.RLIMIT_FSIZE, (full, full))
simulator = Simulator(builder.Build())
for end in (2.0, 3.5):
    simulator.AdvanceTo(end)
    print(page.status.get("log", ""))
log.close()
"""


def test_the_page_says_that_rows_are_missing(tmp_path):
    answer = subprocess.run(
        [sys.executable, "-c", _PROGRAM, tmp_path],
        cwd=Path(__file__).parents[1] / "recording",
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout.splitlines() == [
        "",
        "trajectory.log lacks 8 ticks: File too large",
    ]
