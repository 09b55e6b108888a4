"""A base on ROS 1, as a process: tells its odometry, prints its commands."""

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry


def show(twist: Twist) -> None:
    print(twist.linear.x, twist.angular.z, flush=True)


def main() -> None:
    rospy.init_node("base")
    publisher = rospy.Publisher("/frankie/odom", Odometry, queue_size=1)
    rospy.Subscriber("/frankie/cmd_vel", Twist, show, queue_size=50)
    message = Odometry()
    message.pose.pose.position.x = 1.5
    message.pose.pose.orientation.w = 1.0
    message.twist.twist.linear.x = 0.3
    rate = rospy.Rate(37)
    while not rospy.is_shutdown():
        message.header.stamp = rospy.Time.now()
        publisher.publish(message)
        rate.sleep()


if __name__ == "__main__":
    main()
