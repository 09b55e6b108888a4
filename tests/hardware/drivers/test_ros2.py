"""ROS 2 without ROS: bytes that another decoder reads, and a bridge."""

import numpy as np
import pytest
from patience import PATIENCE
from robot_process import running
from ros_robot import (
    SENSES,
    Station,
    bridge_to,
    check_bridge,
    check_senses,
)

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
rosbags_typesys = pytest.importorskip(
    "rosbags.typesys", reason="needs rosbags, an independent decoder"
)

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 77

TF = "tf2_msgs/msg/TFMessage"


@pytest.fixture(scope="module")
def store():
    return rosbags_typesys.get_typestore(rosbags_typesys.Stores.ROS2_HUMBLE)


def odometry(x: float = 1.5, forward: float = 0.3) -> ros.Odometry:
    message = ros.Odometry(child_frame_id="base_link")
    message.header.stamp = ros.stamp(wall_utime())
    message.header.frame_id = "map"
    message.pose.pose.position.x = x
    message.pose.covariance = [float(i) for i in range(36)]
    message.twist.twist.linear.x = forward
    message.twist.covariance = [-float(i) for i in range(36)]
    return message


def test_a_twist_is_read_by_another_decoder(store):
    twist = ros.Twist(ros.Vector3(0.5, 1, 2), ros.Vector3(3, 4, -0.25))
    data = twist.serialize()
    assert data[:4] == bytes([0, 1, 0, 0])
    read = store.deserialize_cdr(data, "geometry_msgs/msg/Twist")
    assert (read.linear.x, read.linear.y, read.linear.z) == (0.5, 1, 2)
    assert (read.angular.x, read.angular.y, read.angular.z) == (3, 4, -0.25)
    assert bytes(store.serialize_cdr(read, read.__msgtype__)) == data


def test_an_odometry_is_read_by_another_decoder_and_back(store):
    message = odometry()
    data = message.serialize()
    read = store.deserialize_cdr(data, "nav_msgs/msg/Odometry")
    assert read.header.stamp.sec == message.header.stamp.sec
    assert read.header.stamp.nanosec == message.header.stamp.nanosec
    assert (read.header.frame_id, read.child_frame_id) == ("map", "base_link")
    assert read.pose.pose.position.x == 1.5
    assert read.pose.pose.orientation.w == 1.0
    np.testing.assert_array_equal(read.pose.covariance, np.arange(36.0))
    assert read.twist.twist.linear.x == 0.3
    np.testing.assert_array_equal(read.twist.covariance, -np.arange(36.0))
    again = bytes(store.serialize_cdr(read, read.__msgtype__))
    assert ros.Odometry.deserialize(again) == message


def test_localisations_and_flags_are_read_by_another_decoder(store):
    pose = ros.PoseWithCovarianceStamped(ros.Header(frame_id="map"))
    pose.pose.pose.position.y = -2.0
    pose.pose.covariance[35] = 0.01
    data = pose.serialize()
    name = "geometry_msgs/msg/PoseWithCovarianceStamped"
    read = store.deserialize_cdr(data, name)
    assert (read.header.frame_id, read.pose.pose.position.y) == ("map", -2.0)
    assert read.pose.covariance[35] == 0.01
    assert bytes(store.serialize_cdr(read, name)) == data

    found = ros.TransformStamped(ros.Header(frame_id="map"), "odom")
    found.transform.translation.x = 3.0
    data = ros.TFMessage([found, ros.TransformStamped()]).serialize()
    register = rosbags_typesys.get_types_from_msg
    store.register(register("geometry_msgs/TransformStamped[] transforms", TF))
    read = store.deserialize_cdr(data, TF)
    assert read.transforms[0].child_frame_id == "odom"
    assert read.transforms[0].transform.translation.x == 3.0
    assert bytes(store.serialize_cdr(read, TF)) == data

    read = store.deserialize_cdr(
        ros.Bool(True).serialize(), "std_msgs/msg/Bool"
    )
    assert read.data


@pytest.mark.parametrize(
    ("message", "name"),
    [
        (ros.Twist, "geometry_msgs::msg::dds_::Twist_"),
        (ros.Odometry, "nav_msgs::msg::dds_::Odometry_"),
        (ros.Header, "std_msgs::msg::dds_::Header_"),
        (ros.TFMessage, "tf2_msgs::msg::dds_::TFMessage_"),
        (ros.Bool, "std_msgs::msg::dds_::Bool_"),
        (ros.Time, "builtin_interfaces::msg::dds_::Time_"),
    ],
)
def test_types_have_the_names_that_ros_gives_them(message, name):
    assert message.__idl_typename__.replace(".", "::") == name


def test_topics_have_the_names_that_ros_gives_them():
    assert ros.dds_topic("/frankie/cmd_vel") == "rt/frankie/cmd_vel"
    assert ros.dds_topic("odom") == "rt/odom"


class Robot:
    """A base on DDS: hears `cmd_vel`, tells its odometry."""

    def __init__(self):
        participant = DomainParticipant(DOMAIN)
        self._reader = DataReader(
            participant,
            Topic(participant, "rt/frankie/cmd_vel", ros.Twist),
            qos=Qos(
                Policy.Reliability.Reliable(10_000_000),
                Policy.History.KeepLast(50),
            ),
        )
        self._writer = DataWriter(
            participant,
            Topic(participant, "rt/frankie/odom", ros.Odometry),
            qos=Qos(Policy.Reliability.BestEffort),
        )

    def send(self, x: float, forward: float) -> None:
        self._writer.write(odometry(x, forward))

    def received(self) -> list[tuple[float, float]]:
        return [(s.linear.x, s.angular.z) for s in self._reader.take(N=50)]


@pytest.mark.slow
def test_a_base_is_driven_through_the_bridge():
    url = free_url()
    robot, commands = Robot(), []

    def exchange(x: float, forward: float) -> None:
        robot.send(x, forward)
        commands.extend(robot.received())

    line = bridge_to("Ros2Base", url, f"domain: {DOMAIN}")
    with running(*line) as bridge:
        check_bridge(bridge, Station(url), commands, exchange)
        robot.received()
        bridge.terminate()
        assert bridge.wait(PATIENCE) == 0
    assert set(robot.received()) == {(0.0, 0.0)}


@pytest.mark.slow
def test_stops_and_localisations_go_through_the_bridge():
    url = free_url()
    robot, participant = Robot(), DomainParticipant(DOMAIN)

    def writer(name: str, kind) -> DataWriter:
        return DataWriter(participant, Topic(participant, name, kind))

    stop = writer("rt/e_stop", ros.Bool)
    amcl = writer("rt/amcl_pose", ros.PoseWithCovarianceStamped)
    tf = writer("rt/tf", ros.TFMessage)

    def tell(pressed: bool | None) -> None:
        robot.send(1.5, 0.3)
        if pressed is not None:
            stop.write(ros.Bool(pressed))
        amcl.write(ros.PoseWithCovarianceStamped(odometry().header))
        found = ros.TransformStamped(odometry().header, "odom")
        tf.write(ros.TFMessage([found]))

    line = bridge_to("Ros2Base", url, f"domain: {DOMAIN}, {SENSES}")
    with running(*line) as bridge:
        check_senses(bridge, url, tell)
        bridge.terminate()
        assert bridge.wait(PATIENCE) == 0
