"""Three operators who want anything at any time: the bounds hold."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.target_state import MODES, TargetState
from remosplat_drake.teleop.merging import MergedCommand, merge_commands
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.target_motion import advance_target
from remosplat_drake.teleop.teleop_config import SavedPose, TeleopConfig

DT = 0.02
CONFIG = TeleopConfig(
    workspace_lower=[-1, -1, 0],
    workspace_upper=[1, 1, 1],
    poses={"shelf": SavedPose([0.5, 0, 0.5])},
)
COUNTS = ("moves", "holds", "homes", "poses", "scans")


def anything(
    command: OperatorCommand, rng: np.random.Generator
) -> OperatorCommand:
    """The command with one thing changed."""
    changes = {name: {name: getattr(command, name) + 1} for name in COUNTS}
    angles = rng.uniform(-180, 180, 3)
    X_WT = SavedPose(list(2 * rng.normal(size=3)), list(angles)).matrix()
    changes["moves"]["X_WT"] = X_WT
    changes["poses"]["pose"] = str(rng.choice(["shelf", "nowhere"]))
    changes["pressed"] = {"V_W": rng.normal(size=6)}
    changes["let go"] = {"V_W": None}
    changes["trouble"] = {"trouble": "" if command.trouble else "silent"}
    return dc.replace(command, **changes[str(rng.choice(list(changes)))])


@pytest.mark.parametrize("seed", range(4))
def test_whatever_is_wished_the_target_keeps_its_bounds(seed):
    rng = np.random.default_rng(seed)
    X_WE = SavedPose([0, 0, 0.5]).matrix()
    law = MotionLaw(CONFIG, X_WE, DT, np.eye(4), 4)
    state = TargetState.at_rest(X_WE)
    sources = [OperatorCommand(source=name) for name in "abc"]
    merged = MergedCommand.silent(3)
    for tick in range(600):
        if rng.random() < 0.1:
            i = rng.integers(3)
            sources[i] = anything(sources[i], rng)
        merged = merge_commands(merged, sources)
        # Now and then the robot's place is not known.
        known = rng.random() > 0.02
        state = advance_target(
            law,
            state,
            merged.command,
            X_WE if known else np.full((4, 4), np.nan),
            tick * DT,
        )
        X_WT, V_WT = state.X_WT, state.V_WT
        assert state.mode in MODES
        assert (X_WT[:3, 3] >= CONFIG.workspace_lower).all()
        assert (X_WT[:3, 3] <= CONFIG.workspace_upper).all()
        np.testing.assert_allclose(
            X_WT[:3, :3] @ X_WT[:3, :3].T, np.eye(3), atol=1e-9
        )
        assert np.linalg.norm(V_WT[3:]) <= CONFIG.max_speed + 1e-9
        assert np.linalg.norm(V_WT[:3]) <= CONFIG.max_rotation + 1e-9
        # The robot lags behind.
        p_WE = X_WE[:3, 3] + 0.2 * (X_WT[:3, 3] - X_WE[:3, 3])
        X_WE = X_WT.copy()
        X_WE[:3, 3] = p_WE
