"""`BaseLocalization`: the system that corrects the base's odometry."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    DiscreteValues,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.robot.planar_pose import (
    composed,
    largest_error,
    odometry_frame,
    stepped,
)
from remosplat_drake.signals.base_correction import BaseCorrection

SIGMAS = 3.0
"""The bound on the base's error is this many standard deviations."""


class BaseLocalization(LeafSystem):
    """Transforms the measured configuration to the map's frame.

    .. pydrake_system::

        name: BaseLocalization
        input_ports:
        - configuration
        - correction (optional)
        - base_uncertainty (optional)
        output_ports:
        - configuration
        - base_uncertainty

    The input is the measured q, whose base is in the odometry's frame O; the
    output is q in the map's frame W. `correction` is a `BaseCorrection`. The
    applied correction changes slowly towards this input, so that the controller
    is not disturbed. But the correction of a new map takes effect at once,
    because the map and the base's pose in it then change together. Commands
    need no correction, since they are velocities in the base's own frame.

    `base_uncertainty` bounds the errors of the base's position [m] and heading
    [rad]. The input bounds the error of the measured pose. The output is larger
    by two parts: a bound from the correction's covariance, which grows between
    frames, and the part of the correction that is not applied yet.
    """

    def __init__(self, *, n_q: int, period: float, speed: float):
        """Declares state and ports.

        Args:
            n_q: Length of a configuration.
            period: Time between two steps [s].
            speed: Greatest speed of the correction, at the base [m/s, rad/s].
        """
        super().__init__()
        self.set_name("base_localization")
        self._most = speed * period
        self._measured = self.DeclareVectorInputPort("configuration", n_q)
        self._correction = self.DeclareAbstractInputPort(
            "correction", Value(BaseCorrection())
        )
        self._uncertainty = self.DeclareVectorInputPort("base_uncertainty", 2)
        # The state is x, y, yaw of X_WO, and the version of the map.
        state = self.DeclareDiscreteState(4)
        # Time is no input of this update: it matters only if the version
        # changes, and then the correction changes, too.
        known = {
            self._measured.ticket(),
            self._correction.ticket(),
            self.discrete_state_ticket(state),
        }
        self.DeclareVectorOutputPort(
            "configuration", n_q, self._calc_configuration, known
        )
        self.DeclareVectorOutputPort(
            "base_uncertainty",
            2,
            self._calc_uncertainty,
            {*known, self._uncertainty.ticket(), self.time_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, configuration: OutputPort, **arguments
    ) -> "BaseLocalization":
        """Adds a localisation to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q.
            **arguments: The arguments of `BaseLocalization`.
        """
        system = builder.AddSystem(BaseLocalization(**arguments))
        builder.Connect(configuration, system.GetInputPort("configuration"))
        return system

    def _calc_configuration(self, context: Context, output: BasicVector):
        measured = self._measured.Eval(context)
        pose = self._in_effect(context)[:3]
        output.SetFromVector([*composed(pose, measured[:3]), *measured[3:]])

    def _calc_uncertainty(self, context: Context, output: BasicVector):
        bound = np.zeros(2)
        if self._uncertainty.HasValue(context):
            bound = self._uncertainty.Eval(context)
        if self._correction.HasValue(context):
            correction = self._correction.Eval(context)
            X_OB = self._measured.Eval(context)[:3]
            X_WB, P = correction.base_at(context.get_time(), X_OB)
            told = composed(self._in_effect(context)[:3], X_OB)
            bound = bound + largest_error(P, SIGMAS, X_WB, told)
        output.SetFromVector(bound)

    def _in_effect(self, context: Context) -> np.ndarray:
        """Returns X_WO and the map version; a new version applies at once."""
        known = context.get_discrete_state(0).CopyToVector()
        if not self._correction.HasValue(context):
            return known
        correction = self._correction.Eval(context)
        if correction.version == known[3]:
            return known
        X_OB = self._measured.Eval(context)[:3]
        X_WB, _ = correction.base_at(context.get_time(), X_OB)
        return np.append(odometry_frame(X_WB, X_OB), correction.version)

    def _step(self, context: Context, state: DiscreteValues):
        if not self._correction.HasValue(context):
            return
        *pose, version = self._in_effect(context)
        X_OB = self._measured.Eval(context)[:3]
        correction = self._correction.Eval(context)
        goal, _ = correction.base_at(context.get_time(), X_OB)
        after = stepped(np.array(pose), goal, X_OB, self._most)
        state.set_value(0, np.append(after, version))
