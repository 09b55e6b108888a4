"""Names of the LCM channels between station and drivers, and expiry times.

Stamps on all channels are wall clock times, in microseconds of the Unix epoch.
A command has expired if its stamp differs too much from the driver's clock, to
the past or the future. The driver then commands zero velocity. A command with a
braking ramp is held for 1.5 control periods, and then the driver follows the
ramp to zero.
"""

COMMAND_RAMP = "COMMAND_RAMP"
"""command_ramp: braking ramp of the robot after the command with the same
stamp.
"""

PANDA_COMMAND = "PANDA_COMMAND"
"""lcmt_panda_command: joint rates, to drake-franka-driver or another arm
driver."""
PANDA_STATUS = "PANDA_STATUS"
"""lcmt_panda_status: measured joints and the robot's mode, at 1 kHz."""
PANDA_HAND_COMMAND = "PANDA_HAND_COMMAND"
"""lcmt_schunk_wsg_command: width and force of the Franka hand."""
PANDA_HAND_STATUS = "PANDA_HAND_STATUS"
"""lcmt_schunk_wsg_status: measured width of the Franka hand, at 10 Hz."""
BASE_COMMAND = "BASE_COMMAND"
"""base_command: speeds forward and to the left, and yaw rate."""
BASE_STATUS = "BASE_STATUS"
"""base_status: odometry and stops of the base, at 10 Hz or more."""
BASE_LOCALIZATION = "BASE_LOCALIZATION"
"""base_localization: pose of the base in the map, from a localisation."""
MOVERS = "MOVERS"
"""mover_list: movers from a perception process, and the space that it observes.
"""
COUNTING_MAP = "COUNTING_MAP"
"""counting_map: the version of its live map that a control loop uses."""
WRIST_CAMERA = "WRIST_CAMERA"
"""lcmt_image_array: an RGB and a depth image of the wrist camera."""

COMMAND_EXPIRY = 0.1
"""A driver drops a command whose stamp differs from the driver's clock by more
than this time, in the past or the future [s]."""
STATUS_EXPIRY = 0.05
"""A status of the arm is stale at this age [s]."""
BASE_STATUS_EXPIRY = 0.25
"""A status of the base is stale at this age [s]. Its odometry may have a rate
of only 10 Hz, and one message may be lost.
"""
HAND_STATUS_EXPIRY = 0.5
"""A status of the hand is stale at this age [s]."""
