"""Faults of a robot on ROS 2, behind `arm-driver` and `base-driver`."""

from remosplat_drake.acceptance.fault_case import robot_fault

CASES = (
    robot_fault(
        "joint states 0.3 s old, on ROS 2",
        "status-delay",
        "PANDA_STATUS",
        value=0.3,
        ros2=True,
    ),
    robot_fault(
        "joint states stop, on ROS 2",
        "status-stops",
        "nothing came for",
        ros2=True,
    ),
    # The reasons of these stops are not compared. Topics of stops have a low
    # rate, so the statuses may contradict the actuator models before.
    robot_fault(
        "emergency stop of the arm, on ROS 2",
        "user-stop",
        "",
        refusal="user_stopped",
        ros2=True,
    ),
    robot_fault(
        "emergency stop of the base, on ROS 2",
        "base-emergency-stop",
        "",
        refusal="emergency",
        ros2=True,
    ),
)
