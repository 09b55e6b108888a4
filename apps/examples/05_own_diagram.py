"""The controller in a diagram of your own, with a plant of your own."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

import remosplat_drake as rs

SPLAT = "package://remosplat_drake/models/scenes/table/splat.ply"


class Integrator(LeafSystem):
    """A robot that follows its commands exactly: q' = N(q) u."""

    def __init__(self, robot: rs.RobotModel):
        """Declares the ports; the state is q."""
        super().__init__()
        self._robot = robot
        self._u = self.DeclareVectorInputPort("u", robot.n_u)
        self.DeclareStateOutputPort("q", self.DeclareContinuousState(robot.n_q))

    def DoCalcTimeDerivatives(self, context, derivatives) -> None:
        """Converts velocities of wheels and joints to rates of q."""
        q = context.get_continuous_state_vector().CopyToVector()
        u = self._u.Eval(context)
        derivatives.SetFromVector(self._robot.velocity_map(q) @ u)


def main() -> None:
    """Reaches over the table, and prints the final position of the hand."""
    robot = rs.load_robot("frankie", floor_height=0.03)
    field = rs.SphereToEllipsoid().make(rs.read_splat(SPLAT))
    X_WT = RigidTransform(RollPitchYaw(np.pi, 0, 0), [0.9, 0.45, 0.95])

    builder = DiagramBuilder()
    plant = builder.AddSystem(Integrator(robot))
    q = plant.GetOutputPort("q")
    oracle = rs.DistanceOracle.AddToBuilder(
        builder, robot=robot, field=field, configuration=q
    )
    target = rs.TargetSequence.AddToBuilder(
        builder, robot=robot, X_WTs=[X_WT], configuration=q
    ).GetOutputPort("target")
    law = rs.ReactiveLaw(robot, rs.default_ingredients(robot), dt=0.01)
    u = rs.ReactiveController.AddToBuilder(
        builder, law=law, oracle=oracle, configuration=q, target=target
    ).GetOutputPort("velocity_commanded")
    builder.Connect(u, plant.GetInputPort("u"))

    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    context.SetContinuousState(robot.q_home)
    simulator.AdvanceTo(6.0)
    p_WE = robot.end_effector_pose(q.Eval(context))[:3, 3]
    print(f"hand at {np.round(p_WE, 3)}, wanted {X_WT.translation()}")


if __name__ == "__main__":
    main()
