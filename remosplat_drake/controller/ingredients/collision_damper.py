"""Slow down before the scene: the paper's hard collision constraint."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.oracle.distance_field import Clearances
from remosplat_drake.robot.robot_model import RobotState

NAME = "collision"


@dc.dataclass
class CollisionDamperConfig:
    """How close the robot may come, and how fast."""

    # Distance d_i within which the scene matters [m].
    influence: float = 0.5
    # Distance d_s that is kept [m].
    stopping: float = 0.021
    # Largest approach speed xi at the influence distance [m/s].
    gain: float = 1.0


def collision_rows(state: RobotState, clearances: Clearances) -> np.ndarray:
    """Rates at which clearances shrink, n' Jv_WS, shape (m, n_u)."""
    return np.matvec(
        np.swapaxes(state.Jv_WS[clearances.sphere], 1, 2),
        clearances.direction_W,
    )


class CollisionDamper:
    """n' Jv_WS u <= xi (d - d_s) / (d_i - d_s) (paper section IV-D)."""

    def __init__(self, config: CollisionDamperConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for every clearance within the influence distance."""
        config, clearances = self._config, tick.clearances
        if not len(clearances):
            return
        A = collision_rows(tick.state, clearances)
        margin = clearances.distance - config.stopping
        b = config.gain * margin / (config.influence - config.stopping)
        links = tick.robot.spheres.links
        program.add_rows(NAME, A, b, _SphereLabels(clearances.sphere, links))


class _SphereLabels:
    """Labels made only when a fallback has to name its rows."""

    def __init__(self, sphere: np.ndarray, links: tuple[str, ...]):
        self._sphere = sphere
        self._links = links

    def __len__(self) -> int:
        return len(self._sphere)

    def __getitem__(self, i) -> str:
        sphere = self._sphere[i]
        return f"sphere {sphere} on {self._links[sphere]}"
