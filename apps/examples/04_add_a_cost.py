"""A cost of your own, which makes motion of the base expensive.

You only need to write the class; rollouts use the cost, too. In a scenario, you
add it by `controller: {extra: [!my_module:StandStill {weight: 5}]}`.
"""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

import remosplat_drake as rs


@dc.dataclass
class StandStill(rs.Config):
    """Adds u' W u / 2 with a weight on the base's two velocities."""

    # Weight of the base's squared velocities.
    weight: Annotated[float, Interval(ge=0, le=100)] = 1.0

    def AddToProgram(self, program: rs.ReactiveProgram, tick: rs.Tick) -> None:
        """Adds the cost to the program of one tick."""
        W = np.zeros(program.n_u)
        W[: tick.robot.n_base] = self.weight
        program.add_quadratic_cost("stand still", W)


def main() -> None:
    """Prints the distance that the base travels with and without the cost."""
    for weight in (0.0, 1.0):
        scenario = rs.load_scenario("TableReach")
        cost = StandStill(weight)
        result = rs.run(rs.build(scenario, ingredients=[cost]))
        travel = result.metrics.base_path_length
        print(f"weight {weight:g}: {result.outcome}, base {travel:.3f} m")


if __name__ == "__main__":
    main()
