"""Fixtures for the whole suite."""

import fcntl
import gc
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from effort import effort
from pydrake.common.value import Value
from pydrake.geometry import MakeRenderEngineVtk, RenderEngineVtkParams
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import MissingExtraError
from remosplat_drake.base.system_libraries import (
    MissingLibraryError,
    import_optional,
    libraries_named,
)
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

# CI tries the same examples each time; elsewhere each run tries new ones. None
# has a deadline: a busy computer fails no test.
hypothesis.settings.register_profile(
    "project",
    deadline=None,
    derandomize=bool(os.environ.get("CI")),
    max_examples=effort(40, 100),
)
hypothesis.settings.load_profile("project")

# Where several processes test, they keep the cores busy.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("REMOSPLAT_COMPILERS", "0")

_TESTS = Path(__file__).resolve().parent
THREE_LINK = _TESTS / "data" / "three_link.yaml"
_SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
_SCENE = PrimitiveScene(
    boxes=(Box(RigidTransform([1, 0, 0.4]), np.array([0.3, 0.4, 0.03])),),
    cylinders=(Cylinder(RigidTransform([0.8, 0.1, 0.6]), 0.05, 0.2),),
    X_WE_target=RigidTransform([1, 0, 0.6]),
).with_floor()


LONGEST = (
    "docs/test_documents.py",
    "app/test_hardware_run.py",
    "commands/test_teleop_command.py",
    "acceptance/test_fault_campaign.py",
    "commands/test_reconstruct.py",
    "recording/test_mcap.py",
    "acceptance/test_table_over_the_wire.py",
    "reconstruction/test_alignment.py",
    "fuzz/test_campaign.py",
    "acceptance/test_measured_start.py",
    "commands/test_refined_cameras.py",
    "mapping/test_mapping_process.py",
    "mapping/test_camera_suspicion.py",
    "mapping/test_map_builder.py",
    "studies/test_true_maps.py",
    "test_shipped_scenarios.py",
    "task/test_task_scenarios.py",
    "teleop/test_operator_jobs.py",
    "robot/test_sphere_fitting.py",
    "robot/importing/test_robot_import.py",
    "test_wheel.py",
)
"""Files that take longest. They come first: a worker that gets one does all of
it, and the others would have nothing left to do beside it. Files with a robot
process are apart, since of two tests with one the second waits."""


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """The garbage collector leaves out what the collection of tests makes.

    Nearly all of these objects stay until the end. Python would look through
    all of them again and again, during the collection and during the tests.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]):
    rank = {_TESTS / name: i for i, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path, len(rank)))


@pytest.fixture(scope="session", autouse=True)
def no_progress_lines() -> Iterator[None]:
    """A busy computer adds no lines to what commands say on stderr."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("remosplat_drake.base.progress.BEGUN", np.inf)
        yield


@pytest.fixture(scope="session", autouse=True)
def equal_niceness() -> Iterator[None]:
    """Processes beside a loop do not wait until no other test wants to run."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (
            "controller.guidance.look_ahead_process",
            "mapping.mapping_process",
        ):
            patch.setattr(f"remosplat_drake.{module}._NICENESS", 0)
        yield


@pytest.fixture(scope="session", autouse=True)
def values_without_none() -> Iterator[None]:
    """No output is None: Drake 1.58 refuses that, older ones do not."""
    set_value = Value[object].set_value

    def checked(value, new) -> None:
        if new is None:
            raise TypeError("an output is None, which newer Drakes refuse")
        set_value(value, new)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Value[object], "set_value", checked)
        yield


@pytest.fixture
def lone_robot() -> Iterator[None]:
    """No other test on this computer has a robot process meanwhile.

    A robot and its controller run in real time: two of each leave nothing of
    two cores to what starts beside them.
    """
    path = Path(tempfile.gettempdir(), f"remosplat-robot-{os.getuid()}.lock")
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The team's data folder beside the checkout; skips where it is absent."""
    if not _SHARED_DATA.is_dir():
        pytest.skip("needs the data folder ../shared/data beside the checkout")
    return _SHARED_DATA


@pytest.fixture(scope="session")
def open3d() -> None:
    """Skips where Open3D is not installed, or lacks something it needs."""
    try:
        import_optional("open3d", "this test", "reconstruction")
    except MissingExtraError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def rendering() -> None:
    """Skips where nothing can be rendered, here or in another process."""
    with libraries_named("rendering"):
        MakeRenderEngineVtk(RenderEngineVtkParams())


@pytest.fixture(scope="session")
def frankie() -> RobotModel:
    """The mobile manipulator with its covering spheres, on the floor."""
    return load_robot("frankie", floor_height=0.03)


@pytest.fixture(scope="session")
def three_link() -> RobotModel:
    """An arm in the x-z plane on a fixed base, small enough to work by hand."""
    return load_robot(THREE_LINK)


@pytest.fixture(scope="session")
def lift_arm() -> RobotModel:
    """The arm of `three_link` on a lift that travels 0.35 m."""
    return load_robot(THREE_LINK.with_name("lift_arm.yaml"))


@pytest.fixture(scope="session")
def two_pandas() -> RobotModel:
    """The shipped robot with two arms, and a hand on each."""
    return load_robot("two_pandas")


@pytest.fixture(scope="session")
def two_arms() -> RobotModel:
    """Two arms of six joints on a torso that turns."""
    return load_robot(THREE_LINK.with_name("two_arms.yaml"))


@pytest.fixture(scope="session")
def scene() -> PrimitiveScene:
    """A cylinder on a board, and a floor."""
    return _SCENE


@pytest.fixture(scope="session")
def scene_capture(scene):
    """Twelve small views of `scene`."""
    return render_capture(scene, survey_poses(scene, n=12), 120, 90)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    return (yield from skipping_what_the_system_lacks())


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    return (yield from skipping_what_the_system_lacks())


def skipping_what_the_system_lacks():
    """A test that needs an absent library of the system, as rendering does."""
    try:
        return (yield)
    except MissingLibraryError as error:
        pytest.skip(str(error))
