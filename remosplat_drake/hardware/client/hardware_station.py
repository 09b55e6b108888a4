"""`HardwareStation`: the real robot behind the ports of every station."""

from drake import lcmt_image_array
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.lcm import LcmInterfaceSystem, LcmSubscriberSystem
from pydrake.systems.sensors import LcmImageArrayToImages

from remosplat_drake.hardware.client.remote_robot import RemoteRobot
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.export import export_ports


class HardwareStation(Diagram):
    """The real robot as a diagram with the ports of every station.

    Its ports are those of `signals.station_ports`, and no others. It hears
    the drivers when it is told to `receive`, and sends a command when it is
    told to publish (`ForcedPublish`); never otherwise. See `RemoteRobot`.

    Attributes:
        link: The LCM connection to the robot's drivers.
    """

    def __init__(
        self,
        *,
        config: HardwareConfig,
        robot: RobotModel,
        wrist_camera: bool,
    ):
        """Builds the station and opens the wire.

        Args:
            config: LCM URL, channels and expiry times of the drivers.
            robot: The robot; its description names the ports.
            wrist_camera: Whether the station has the wrist camera's ports.

        Raises:
            RemoSplatError: The wire cannot be opened.
        """
        super().__init__()
        self.link = RobotLink(config, robot)
        builder = DiagramBuilder()
        self._robot = builder.AddNamedSystem(
            "remote_robot",
            RemoteRobot(robot=robot, link=self.link, config=config),
        )
        images = None
        if wrist_camera:
            images = _add_camera(builder, config)
        export_ports(builder, robot.description, [self._robot], images)
        builder.BuildInto(self)
        self.set_name("station")

    def receive(self, root: Context) -> None:
        """Takes the packets that the link has heard onto the ports.

        Args:
            root: Context of the whole diagram, between two steps of it.
        """
        self._robot.receive(self._robot.GetMyMutableContextFromRoot(root))


def _add_camera(builder: DiagramBuilder, config: HardwareConfig):
    """The latest images, as the simulated camera renders them.

    They have a wire of their own, which Drake reads while the diagram
    advances: newer Drakes do that without Python's lock, so nothing written
    in Python, as the link's mailboxes are, may hang on it.
    """
    lcm = config.open_lcm()
    builder.AddNamedSystem("lcm", LcmInterfaceSystem(lcm=lcm))
    subscriber = builder.AddNamedSystem(
        "wrist_camera_subscriber",
        LcmSubscriberSystem.Make(
            config.channels.wrist_camera,
            lcmt_image_array,
            lcm,
            use_cpp_serializer=True,
        ),
    )
    images = builder.AddNamedSystem("wrist_camera", LcmImageArrayToImages())
    builder.Connect(subscriber.get_output_port(), images.get_input_port())
    return {
        ports.WRIST_CAMERA_RGB: images.GetOutputPort("color_image"),
        ports.WRIST_CAMERA_DEPTH: images.GetOutputPort("depth_image"),
    }
