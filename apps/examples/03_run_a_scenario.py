"""Loads a scenario in Python, changes it, builds it and runs it."""

import remosplat_drake as rs


def main() -> None:
    """Reaches for the table with a larger stopping distance than usual."""
    scenario = rs.load_scenario("TableReach")
    scenario.controller.collision.stopping = 0.03
    scenario.controller.guidance.tiers = [0.02]
    result = rs.run(rs.build(scenario))

    metrics = result.metrics
    print(f"{result.outcome}: {result.targets_reached} of {result.targets}")
    print(f"after {metrics.duration:.2f} s, {metrics.path_length:.2f} m")
    print(f"nearest to the true scene: {metrics.truth_clearance_min:.4f} m")


if __name__ == "__main__":
    main()
