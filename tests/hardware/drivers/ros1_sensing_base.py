"""A base on ROS 1 that tells where it is, and its emergency stop.

A line on stdin, "pressed" or "free", says what it tells of that; before the
first one it tells nothing.
"""

import sys
import threading

import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage


class EmergencyStop:
    """What was last said of it."""

    def __init__(self):
        self.pressed: bool | None = None

    def listen(self) -> None:
        for line in sys.stdin:
            self.pressed = line.strip() == "pressed"


def main() -> None:
    rospy.init_node("base")
    stop = EmergencyStop()
    threading.Thread(target=stop.listen, daemon=True).start()

    def publisher(topic: str, kind) -> rospy.Publisher:
        return rospy.Publisher(topic, kind, queue_size=1)

    odometry = publisher("/frankie/odom", Odometry)
    amcl = publisher("/amcl_pose", PoseWithCovarianceStamped)
    tf = publisher("/tf", TFMessage)
    flag = publisher("/e_stop", Bool)
    driving = Odometry()
    driving.pose.pose.orientation.w = 1.0
    driving.twist.twist.linear.x = 0.3
    pose = PoseWithCovarianceStamped()
    pose.pose.pose.orientation.w = 1.0
    found = TransformStamped(child_frame_id="odom")
    found.transform.rotation.w = 1.0
    rate = rospy.Rate(37)
    while not rospy.is_shutdown():
        for message in (driving, pose, found):
            message.header.stamp = rospy.Time.now()
        for message in (pose, found):
            message.header.frame_id = "map"
        odometry.publish(driving)
        amcl.publish(pose)
        tf.publish(TFMessage([found]))
        if stop.pressed is not None:
            flag.publish(Bool(stop.pressed))
        rate.sleep()


if __name__ == "__main__":
    main()
