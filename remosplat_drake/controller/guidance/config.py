"""`GuidanceConfig`: how far and how much the selector looks ahead."""

import dataclasses as dc


@dc.dataclass
class GuidanceConfig:
    """Rollout-selected guidance; without it the controller is reactive."""

    # Whether guidance is selected at all.
    enabled: bool = True
    # Rollout steps that a control tick may spend; each costs about 0.6 ms
    # with ellipsoids, and 10 leave room in a period of 10 ms. With 0 nothing
    # is simulated: whenever the robot stalls, the next candidate is tried.
    budget: int = 10
    # Look ahead in a process of its own, so that ticks do not wait for it:
    # for real robots. Runs then depend on the machine, and `budget` is idle.
    asynchronous: bool = False
    # How long that process takes for an answer [ms], best a little less than
    # the control period; what it has not finished it goes on with.
    budget_ms: float = 8.0
    # Convex solver of the rollouts; see controller/solvers.py.
    solver: str = "active_set"
    # Time that one rollout step simulates [s].
    step: float = 0.1
    # Longest time that a rollout simulates [s].
    horizon: float = 8.0
    # Angle by which the base turns towards the side that is taken [rad].
    bearing: float = 0.8
    # Factor on the active collision cost while passing on a side.
    active_scale: float = 0.5
    # Smaller stopping distances that may be tried when nothing arrives with
    # the usual one, largest first [m]. Needs a map that is accurate enough:
    # scene.map_error.
    tiers: list[float] = dc.field(default_factory=list)
