"""The package as people install it: a wheel, away from the checkout."""

import json
import os
import subprocess
import sys
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest
from patience import PATIENCE

pytest.importorskip("build", reason="needs the dev dependency `build`")
pytest.importorskip("hatchling", reason="needs the dev dependency `hatchling`")

pytest.importorskip("wheel", reason="needs the dev dependency `wheel`")

from apps.packaging.wheel import build
from remosplat_drake.base.kernels import files

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "remosplat_drake"

# Runs the main job; then says where it came from, and which of the heavy
# packages it tried to import, whether they are installed or not.
MAIN_JOB = """
import json, sys
wanted = set()
class Watch:
    def find_spec(self, name, path=None, target=None):
        if name in ("torch", "gsplat", "open3d"):
            wanted.add(name)
sys.meta_path.insert(0, Watch())
import remosplat_drake
from remosplat_drake.base import resources
from remosplat_drake.commands.main import main
code = main(sys.argv[1:])
print(json.dumps({
    "code": code, "package": remosplat_drake.__file__,
    "models": str(resources.models_dir()), "wanted": sorted(wanted),
}))
"""


def clean_environment() -> dict[str, str]:
    """Nothing that could lead Python back to the checkout."""
    return {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}


def run_job(
    python: Path | str, cwd: Path, *arguments: str, **environment: str
) -> dict:
    result = subprocess.run(
        [python, "-c", MAIN_JOB, *arguments],
        cwd=cwd,
        env=clean_environment() | environment,
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
    )
    assert result.returncode == 0, result.stderr
    return {
        "stdout": result.stdout,
        "stderr": result.stderr,
        **json.loads(result.stdout.splitlines()[-1]),
    }


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation"]
    subprocess.run(
        [*command, "--outdir", folder, ROOT],
        check=True,
        capture_output=True,
        cwd=folder,
    )
    (file,) = folder.glob("*.whl")
    return file


def test_the_wheel_holds_package_models_and_scenarios(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    places = {
        PACKAGE: PACKAGE,
        "models": f"{PACKAGE}/share/models",
        "scenarios": f"{PACKAGE}/share/scenarios",
    }
    expected = {
        f"{place}/{path.relative_to(ROOT / folder)}"
        for folder, place in places.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {name for name in names if name.startswith(PACKAGE + "/")} == (
        expected
    )
    assert f"{PACKAGE}/share/models/scenes/table/splat.ply" in names


def test_it_finds_its_scenarios_wherever_it_is_unpacked(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    # The first entry of the path of `python -c` is the working directory.
    job = run_job(sys.executable, tmp_path / "site", "scenarios")
    assert job["code"] == 0
    assert Path(job["package"]).is_relative_to(tmp_path)
    assert Path(job["models"]).is_relative_to(tmp_path)


@pytest.mark.slow
def test_a_wheel_with_kernels_compiles_nothing(tmp_path):
    """And says what its kernels are for where they do not fit."""
    (path,) = build(tmp_path / "dist").parent.iterdir()
    assert path.stat().st_size < 20e6
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "site")
        (name,) = (n for n in archive.namelist() if n.endswith("/METADATA"))
        metadata = archive.read(name).decode()
    for package in ("numba", "llvmlite"):
        assert f"Requires-Dist: {package}=={version(package)}\n" in metadata
    cache = tmp_path / "cache"
    environment = {"NUMBA_CACHE_DIR": str(cache)}
    job = run_job(
        sys.executable, tmp_path / "site", "run", "--headless", **environment
    )
    assert job["code"] == 0
    assert Path(job["package"]).is_relative_to(tmp_path)
    assert "compiling" not in job["stderr"]
    assert not list(cache.glob("*.kernel"))
    (made,) = (tmp_path / "site").rglob(files.MADE_FOR)
    made.write_text("Python 2")
    for kernel in made.parent.glob("chain-*"):
        kernel.unlink()
    job = run_job(
        sys.executable, tmp_path / "site", "run", "--headless", **environment
    )
    assert (
        "the package's kernels are for Python 2, but this computer has"
        in job["stderr"]
    )
    # What it contains is compiled with it.
    compiled = {kernel.name.split("-")[0] for kernel in cache.glob("*.kernel")}
    assert compiled == {"chain", "advance"}


@pytest.mark.smoke
def test_the_main_job_imports_no_gpu_package(tmp_path):
    job = run_job(sys.executable, tmp_path, "run", "--headless")
    assert job["code"] == 0
    assert "reached" in job["stdout"]
    assert job["wanted"] == []


@pytest.mark.slow
def test_the_main_job_runs_from_a_clean_environment(wheel, tmp_path):
    """A minute of installing and compiling: pip fetches the dependencies."""
    environment, elsewhere = tmp_path / "venv", tmp_path / "elsewhere"
    venv.create(environment, with_pip=True)
    elsewhere.mkdir()
    scripts = environment / "bin"
    subprocess.run(
        [scripts / "python", "-m", "pip", "install", "--quiet", wheel],
        check=True,
        cwd=elsewhere,
        env=clean_environment(),
    )
    job = run_job(scripts / "python", elsewhere, "run", "--headless")
    assert job["code"] == 0
    assert "reached" in job["stdout"]
    assert Path(job["package"]).is_relative_to(environment)
    assert Path(job["models"]).is_relative_to(environment)
    assert job["wanted"] == []
    result = subprocess.run(
        [scripts / "remosplat", "run", "--headless"],
        cwd=elsewhere,
        env=clean_environment(),
        timeout=PATIENCE,
    )
    assert result.returncode == 0
    assert not list(elsewhere.iterdir())
