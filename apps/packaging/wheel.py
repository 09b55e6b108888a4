"""Builds a wheel with compiled kernels: `make wheel`.

The wheel is for the Python that runs this module, for processors from x86-64-v3
on, and for the installed versions of Numba and llvmlite. With other versions,
its kernels are not used, and the first start compiles them.
"""

import argparse
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

from remosplat_drake.base.kernels import files, target

ROOT = Path(__file__).resolve().parents[2]

SCENARIOS = (
    "{}",
    "{scene: {unknown: obstacle}}",
    "{oracle: !DepthRasterization {}}",
)
"""Overrides of the default scenario: the wheel contains the kernels of these
runs."""

PLATFORM = "manylinux_2_28_x86_64"


def build(folder: Path) -> Path:
    """Builds the wheel for this Python, and returns its path.

    Args:
        folder: Output folder of the wheel.
    """
    with TemporaryDirectory() as name:
        work = Path(name)
        plain = _built(work / "plain")
        _run("wheel", "unpack", plain, "--dest", work / "open")
        (content,) = (work / "open").iterdir()
        kernels = content / "remosplat_drake" / files.PACKAGED.name
        _bring_kernels(kernels)
        _require_exactly(content)
        (work / "packed").mkdir()
        _run("wheel", "pack", content, "--dest-dir", work / "packed")
        (wheel,) = (work / "packed").iterdir()
        folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.move(wheel, folder / wheel.name))


def _built(folder: Path) -> Path:
    _run("build", "--wheel", "--no-isolation", "--outdir", folder, ROOT)
    (wheel,) = folder.glob("*.whl")
    return wheel


def _bring_kernels(folder: Path) -> None:
    """Writes the kernels of the scenarios to a folder."""
    folder.mkdir()
    for text in SCENARIOS:
        command = [sys.executable, "-m", "apps.packaging.used_kernels", text]
        found = subprocess.run(
            command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True
        )
        for path in map(Path, found.stdout.split("\n")[:-1]):
            shutil.copyfile(path, folder / path.name)
    (folder / files.MADE_FOR).write_text(files.made_for())


def _require_exactly(content: Path) -> None:
    """Adds the versions of packages that the kernels require to the wheel."""
    (info,) = content.glob("*.dist-info")
    metadata = info / "METADATA"
    head, separator, text = metadata.read_text().partition("\n\n")
    for name in ("numba", "llvmlite"):
        head += f"\nRequires-Dist: {name}=={version(name)}"
    metadata.write_text(head + separator + text)
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}-none-{PLATFORM}"
    wheel = info / "WHEEL"
    text = wheel.read_text().replace("Tag: py3-none-any", f"Tag: {tag}")
    wheel.write_text(text.replace("Purelib: true", "Purelib: false"))


def _run(module: str, *arguments: object) -> None:
    command = [sys.executable, "-m", module, *map(str, arguments)]
    subprocess.run(command, check=True)


def main() -> None:
    """Builds the wheel, and prints its path."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    arguments = parser.parse_args()
    if target.LEVEL not in files.made_for():
        sys.exit(f"this processor is not of level {target.LEVEL}")
    wheel = build(arguments.output)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
