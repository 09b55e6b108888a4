"""Shows that kernels are compiled, which takes minutes at a first start."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic

from numba.core.event import Event, Listener, install_listener

from remosplat_drake.base.kernel_cache import is_kept
from remosplat_drake.base.progress import Progress, Stage

SECONDS = {
    "oracle.kernels.solid_records.fill_records": 0.3,
    "oracle.kernels.solid_records.fill_boxes": 0.1,
    "splat.bvh_splits.round_outwards": 0.1,
    "splat.bvh_build._build": 2.2,
    "oracle.kernels.solid_records.scatter_rows": 0.1,
    "oracle.kernels.wide_tree.widen": 1.9,
    "oracle.kernels.depth_rasterization_kernel.nearest_pixels": 6.9,
    "robot.kinematics.body_poses": 0.6,
    "robot.kinematics.sphere_points": 0.1,
    "signals.compiled_map.clearance_rows": 2.5,
    "robot.robot_arrays.state_arrays": 0.8,
    "robot.self_collision.kernels.all_distances.count_contacts": 6.8,
    "robot.self_collision.kernels.all_distances.pair_distances": 1.0,
    "robot.target_arrays.asked_error": 1.8,
    "controller.tick.kernels.settle.settle_tick": 54.4,
    "controller.guidance.kernels.rollout_steps.rollout_steps": 15.1,
    "controller.verification.kernels.least_margin.least_margin": 1.1,
    "robot.kinematics.sphere_points_at": 0.6,
    "controller.planning.kernels.inverse_kinematics.reach_from": 1.9,
    "controller.planning.kernels.map_looks.is_off_the_map": 0.5,
    "controller.planning.kernels.self_looks.keeps_off_itself": 0.8,
    "controller.planning.kernels.map_looks.keeps_off_the_map": 0.7,
    "oracle.signed_distance._clearances": 0.8,
    "oracle.kernels.nearest_voxel.query": 0.7,
}
"""How long a core takes to compile the kernels that runs need, by their names
in this package and in the order of a first run [s].

What one of them contains need not be compiled for those that follow. The pace
of the machine at hand is measured meanwhile, so that only the shares matter."""

_PACKAGE = "remosplat_drake."

_OTHERS = 1.0
"""How long any other kernel is expected to take [s]."""

_SURE = 5.0
"""Time after which the measured pace counts as much as the expected one [s]."""

_MOST = 0.95
"""Fraction of a kernel that is at most shown as done while it is compiled."""


@contextmanager
def compiling_shown(progress: Progress) -> Iterator[None]:
    """Shows the kernels that are compiled within the block, if any are.

    Their number is that of the kernels that runs need, whose modules are
    imported, and which are not on disk. Others are counted as they come.

    Args:
        progress: Where they are shown, in place of the stage that is.
    """
    with install_listener("numba:compile", _Listener(progress)):
        yield


class _Listener(Listener):
    """Notes which kernels are compiled, one at a time, and for how long."""

    def __init__(self, progress: Progress):
        self._progress = progress
        self._stage = Stage("compiling kernels", estimate=self._estimate)
        self._before: Stage | None = None
        self._depth = 0
        self._names: list[str] = []
        self._start = 0.0
        self._spent = 0.0
        # What is expected of kernels that are done, of this one, of the rest.
        self._done = self._current = self._rest = 0.0

    def on_start(self, event: Event) -> None:
        """Shows how many kernels are done and how many there are."""
        self._depth += 1
        if self._depth > 1:  # A function that the kernel contains.
            return
        assert event.data is not None
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}.{function.__qualname__}"
        name = name.removeprefix(_PACKAGE)
        self._names.append(name)
        missing = [name for name in SECONDS if self._is_missing(name)]
        self._current = SECONDS.get(name, _OTHERS)
        self._rest = sum(SECONDS[name] for name in missing)
        self._start = monotonic()
        self._stage.done = len(self._names) - 1
        self._stage.total = len(self._names) + len(missing)
        self._before = self._progress.stage
        self._progress.show(self._stage)
        if not self._stage.done:
            self._progress.print_line()

    def on_end(self, event: Event) -> None:
        """Shows again what was shown before."""
        self._depth -= 1
        if self._depth:
            return
        self._spent += monotonic() - self._start
        self._done += self._current
        self._current = 0.0
        if self._before is not None:
            self._progress.show(self._before)

    def _is_missing(self, name: str) -> bool:
        """Whether a kernel may still have to be compiled."""
        module, _, function = name.rpartition(".")
        imported = sys.modules.get(f"{_PACKAGE}{module}")
        return (
            name not in self._names
            and imported is not None
            and not is_kept(getattr(imported, function))
        )

    def _estimate(self) -> tuple[float, float]:
        """Returns the fraction that is done, and the time that is left [s]."""
        pace = (self._spent + _SURE) / (self._done + _SURE)
        done = self._done
        if self._current:
            since = monotonic() - self._start
            done += min(since / pace, _MOST * self._current)
        total = self._done + self._current + self._rest
        return min(done / total, 0.99), (total - done) * pace
