"""Driver processes, which connect a robot's devices to LCM.

Arm: `PandaDriver` exchanges LCM messages, by the rules of `panda_commands`. A
`CallbackProcess` controls the robot. In this process, a `VelocityCallback`
answers every state of the robot with the command of a `VelocityServo`. The
servo smooths commands by a `JointInterpolator` (Ruckig), and checks them
against `panda_limits`. `SharedRecord`s connect the two processes.

Gripper: `HandDriver` uses `PandaPythonHand`.

Mobile base: `BaseDriver` uses `Ros1Link` (rospy) or `Ros2Link` (CycloneDDS).
`base_commands` contains the watchdog, and `ros_conversion` converts between
messages of ROS and of LCM.
"""
