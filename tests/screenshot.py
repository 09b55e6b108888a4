"""Pictures of a page that `MeshcatPage.save_html` wrote, by headless Chromium.

Run it as `python tests/screenshot.py page.html picture.png`.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    # Tabs of several tests or clients are drawn as if each were in front.
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-renderer-backgrounding",
    "--disable-gpu-watchdog",  # It ends what draws slowly.
)
_SETTLE = 6000  # Time the page gets to load and draw [ms of its own clock].
_TIMEOUT = 120  # [s]


def find_chromium() -> str | None:
    """The browser's program, or None where there is none."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next(filter(None, map(shutil.which, names)), None)


def take_screenshot(
    page: Path, picture: Path, size: tuple[int, int] = (1400, 900)
):
    """Draws a page file in software and writes a PNG of `size` pixels."""
    chromium = find_chromium()
    if chromium is None:
        raise SystemExit("needs chromium on the PATH")
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [
                chromium,
                *FLAGS,
                f"--user-data-dir={profile}",
                f"--window-size={size[0]},{size[1]}",
                f"--virtual-time-budget={_SETTLE}",
                f"--screenshot={picture}",
                page.resolve().as_uri(),
            ],
            check=True,
            timeout=_TIMEOUT,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


if __name__ == "__main__":
    take_screenshot(Path(sys.argv[1]), Path(sys.argv[2]))
