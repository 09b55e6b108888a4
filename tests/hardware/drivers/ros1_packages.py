"""ROS 1 from Debian's packages, unpacked into a folder, without root.

    python tests/hardware/drivers/ros1_packages.py FOLDER

The packages are fetched with apt, once; `FOLDER` on PYTHONPATH then makes
rospy importable by any Python 3.11.
"""

import shutil
import subprocess
import sys
from pathlib import Path

PACKAGES = [
    "python3-actionlib-msgs",
    "python3-catkin",
    "python3-catkin-pkg",
    "python3-dateutil",
    "python3-defusedxml",
    "python3-distro",
    "python3-genmsg",
    "python3-genpy",
    "python3-geometry-msgs",
    "python3-nav-msgs",
    "python3-pyparsing",
    "python3-roscpp-msg",
    "python3-rosgraph",
    "python3-rosgraph-msgs",
    "python3-roslib",
    "python3-rosmaster",
    "python3-rospkg",
    "python3-rospy",
    "python3-six",
    "python3-std-msgs",
    "python3-tf2-msgs",
]

_COMPLETE = "complete"


class Unavailable(Exception):
    """There is no apt here, or it does not have the packages."""


def unpacked(cache: Path) -> Path:
    """The folder to put on PYTHONPATH; fills the cache if it is not full.

    Raises:
        Unavailable: The packages cannot be had.
    """
    modules = cache / "usr" / "lib" / "python3" / "dist-packages"
    if (cache / _COMPLETE).exists():
        return modules
    for tool in ("apt-get", "dpkg"):
        if shutil.which(tool) is None:
            raise Unavailable(f"there is no {tool} here")
    downloads = cache / "debs"
    downloads.mkdir(parents=True, exist_ok=True)
    _run(["apt-get", "download", *PACKAGES], downloads)
    for package in sorted(downloads.glob("*.deb")):
        _run(["dpkg", "-x", str(package), str(cache)], cache)
    shutil.rmtree(downloads)
    (cache / _COMPLETE).touch()
    return modules


def _run(command: list[str], folder: Path) -> None:
    result = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=300
    )
    if result.returncode:
        problem = (result.stderr.strip().splitlines() or ["it failed"])[-1]
        raise Unavailable(f"{command[0]}: {problem}")


if __name__ == "__main__":
    print(unpacked(Path(sys.argv[1])))
