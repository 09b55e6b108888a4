"""The live map: what the wrist camera sees becomes what the oracle asks.

`LiveMap` is the system in the diagram. It hands requests to a
`MappingProcess` and swaps in the maps that come back, and never waits for it.
In that process, `worker` takes pictures and makes maps as its `MappingJob`
says; `messages` is what the two processes tell each other.

A map is made by `map_builder.build_map`: `changes` finds what the newest
frames contradict, `carving` and `base_splat` take away what has gone and add
what has come, `known_space` says which part of space was seen at all.

`store` keeps frames and maps of a session on disk.
"""
