"""`DistanceOracle`: a Drake system that evaluates a distance field."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.load import EMPTY, payload_of


class DistanceOracle(LeafSystem):
    """A Drake system that measures distances from robot spheres to the scene.

    .. pydrake_system::

        name: DistanceOracle
        input_ports:
        - configuration
        - distance_field (optional)
        - base_uncertainty (optional)
        - payload (optional)
        output_ports:
        - clearances
        - distance_field

    The output `clearances` is cached: all systems that read it share one
    computation for each configuration and map. The optional input
    `distance_field` is a map that may change while the diagram runs. A new map
    takes effect between two ticks, as a whole. The optional input
    `base_uncertainty` bounds the error of the base's pose, as position and
    heading error [m, rad]. If it is connected, the distances of both outputs
    are reduced by this error; see `UncertainPlacement`. The optional input
    `payload` is the `Load` that the robot carries. The spheres of the load come
    last in `clearances`. If the configuration is not finite, `clearances` is
    `Clearances.unknown`.

    Args:
        robot: The robot, whose forward kinematics places the spheres.
        field: The distance field that is used if the input port
            `distance_field` is not connected.
        max_distance: Clearances beyond this distance are omitted [m].

    Example:
        >>> import remosplat_drake as rs
        >>> from pydrake.systems.framework import DiagramBuilder
        >>> from pydrake.systems.primitives import ConstantVectorSource
        >>> builder = DiagramBuilder()
        >>> robot = rs.load_robot("frankie")
        >>> q = builder.AddSystem(ConstantVectorSource(robot.q_home))
        >>> scene = rs.read_scene("package://remosplat_drake/models/scenes/table/scene.json")
        >>> oracle = rs.DistanceOracle.AddToBuilder(
        ...     builder,
        ...     robot=robot,
        ...     field=rs.GroundTruth().make(truth=scene),
        ...     configuration=q.get_output_port(),
        ... )
    """

    def __init__(
        self, *, robot: RobotModel, field: DistanceField, max_distance: float
    ):
        super().__init__()
        self.set_name("oracle")
        self._robot = robot
        self._field = field
        self._max_distance = max_distance
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._field_input = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        self._uncertainty_input = self.DeclareVectorInputPort(
            "base_uncertainty", 2
        )
        self._payload_input = self.DeclareAbstractInputPort(
            "payload", Value(EMPTY)
        )
        inputs = {
            self._configuration_input.ticket(),
            self._field_input.ticket(),
            self._uncertainty_input.ticket(),
            self._payload_input.ticket(),
        }
        self.DeclareAbstractOutputPort(
            "clearances",
            Value(Clearances.none()).Clone,
            self._calc_clearances,
            inputs,
        )
        self.DeclareAbstractOutputPort(
            "distance_field",
            Value[object]().Clone,
            self._calc_field,
            inputs,
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        robot: RobotModel,
        field: DistanceField,
        configuration: OutputPort,
        max_distance: float = 0.5,
    ) -> "DistanceOracle":
        """Adds an oracle and connects it to the measured configuration.

        Args:
            builder: The builder of the diagram.
            robot: The robot, whose forward kinematics places the spheres.
            field: The distance field that is used if the input port
                `distance_field` is not connected.
            configuration: Output port of the measured configuration q.
            max_distance: Clearances beyond this distance are omitted [m]. It
                must be at least the controller's influence distance.

        Returns:
            The oracle.
        """
        oracle = builder.AddSystem(
            DistanceOracle(robot=robot, field=field, max_distance=max_distance)
        )
        builder.Connect(configuration, oracle.GetInputPort("configuration"))
        return oracle

    @property
    def field(self) -> DistanceField:
        """The field that is used without the input `distance_field`."""
        return self._field

    def _current_field(self, context: Context) -> DistanceField:
        field = self._field
        if self._field_input.HasValue(context):
            field = self._field_input.Eval(context)
        if not self._uncertainty_input.HasValue(context):
            return field
        shift, turn = self._uncertainty_input.Eval(context)
        if shift == turn == 0.0:
            return field
        q = self._configuration_input.Eval(context)
        return UncertainPlacement(field, q[:2], shift, turn)

    def _calc_clearances(self, context: Context, output: AbstractValue):
        q = self._configuration_input.Eval(context)
        field = self._current_field(context)
        payload = payload_of(self._payload_input, context)
        robot = self._robot.holding(payload)
        if not np.isfinite(q).all():
            output.set_value(Clearances.unknown(len(robot.spheres)))
            return
        spheres = robot.spheres_at(q)
        output.set_value(field.clearances(spheres, self._max_distance))

    def _calc_field(self, context: Context, output: AbstractValue):
        output.set_value(self._current_field(context))
