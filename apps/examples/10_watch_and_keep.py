"""Shows a run in the browser, and saves it as one file.

Drake's Meshcat server draws the splat, the robot and its clearances. The saved
page replays the run without Python.
"""

import argparse
from pathlib import Path

import remosplat_drake as rs


def main() -> None:
    """Runs a scenario on a page and saves its replay."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="?", default="run.html")
    parser.add_argument("--scenario", default="TableReach")
    parser.add_argument("--realtime-rate", type=float, default=1.0)
    arguments = parser.parse_args()

    page = rs.MeshcatPage()
    print(f"watch at {page.url}")
    scenario = rs.load_scenario(arguments.scenario)
    application = rs.build(scenario, page=page)
    page.start_recording(0.0)
    result = rs.run(application, realtime_rate=arguments.realtime_rate)
    page.finish_recording()
    page.save_html(arguments.file)
    print(f"{result.outcome}; saved as {arguments.file}")


if __name__ == "__main__":
    main()
