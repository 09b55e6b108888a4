"""`ActuatedCommand`: simulates dead time and lag of a robot's actuators."""

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
)

from remosplat_drake.robot.actuators import ActuatorModel


class ActuatedCommand(LeafSystem):
    """Applies dead time and first-order lag to the velocity of each axis.

    .. pydrake_system::

        name: ActuatedCommand
        input_ports:
        - velocity_commanded
        output_ports:
        - velocity

    The output is the mean velocity of the axes in each step. It is the command
    to a station whose robot executes commands exactly.

    Args:
        model: Dynamic model of the axes; dead times are rounded to whole steps.
        step: Length of a step [s].
    """

    def __init__(self, *, model: ActuatorModel, step: float):
        super().__init__()
        self.set_name("actuators")
        n = len(model.parameters)
        self._model, self._length = model, step
        self._late = np.round(model.delay / step).astype(int)
        # The rows of the state are the velocities, the mean velocities, and the
        # delayed commands.
        self._shape = (3 + int(self._late.max()), n)
        self.DeclareDiscreteState(int(np.prod(self._shape)))
        self._input = self.DeclareVectorInputPort("velocity_commanded", n)
        self.DeclareVectorOutputPort(
            "velocity", n, self._calc_velocity, {self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(step, 0.0, self._step)

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state_vector().value()
        output.SetFromVector(state.reshape(self._shape)[1])

    def _step(self, context: Context, values: DiscreteValues) -> None:
        state = context.get_discrete_state_vector().value()
        u = self._input.Eval(context)
        after = stepped(
            self._model, self._late, state.reshape(self._shape), u, self._length
        )
        values.set_value(after.ravel())


def stepped(
    model: ActuatorModel,
    late: np.ndarray,
    state: np.ndarray,
    u: np.ndarray,
    dt: float,
) -> np.ndarray:
    """Advances delay lines and actuators by one step.

    Args:
        model: Dynamic model of the axes.
        late: Dead time of each axis in steps, shape (n,).
        state: Velocities, mean velocities of the previous step, and the latest
            commands, the newest first, shape (3 + max(late), n).
        u: The command of this step, shape (n,) [m/s, rad/s].
        dt: Length of the step [s].
    """
    n = len(late)
    line = np.vstack([u, state[2:-1]])
    told = line[late, np.arange(n)]
    start = np.zeros(n)
    model = ActuatorModel(
        model.parameters * [0.0, 1.0, 1.0, 1.0], model.tube, model.noise
    )
    way, v = model.response(
        np.array([0.0]), told[None], start, state[0], np.full((1, n), dt)
    )
    return np.vstack([v, way / dt, line])
