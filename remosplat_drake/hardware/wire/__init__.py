"""The wire protocol, which control process and drivers share.

`channels` names the LCM channels and says when a message expires. `packets`
decodes with distrust: what is cut short, of another type or not finite is a
`BrokenMessage`. `panda`, `hand` and `base` turn each device's messages into
values and back; `messages` holds our own LCM types; `inbox` collects packets,
and `command_limits` scales a command into the base's limits.
"""
