"""The LCM protocol between the control process and the drivers.

`channels` contains the names of the LCM channels and the expiry times of
messages. `packets` decodes and checks packets: a packet that is truncated, of
another type or not finite causes a `BrokenMessage`. `panda`, `hand` and `base`
convert each device's messages to values and back. `messages` contains our own
LCM types, `inbox` collects packets, and `command_limits` scales a command to
the base's limits.
"""
