"""The live map: makes maps for the oracle from frames of the wrist camera.

`LiveMap` is the system in the diagram. It passes requests to a
`MappingProcess`, swaps in the resulting maps, and never waits for it. In that
process, `worker` takes pictures and builds maps according to its `MappingJob`;
`messages` defines the messages between the two processes.

A map is made by `map_builder.build_map`: `changes` finds parts that the newest
frames contradict, `carving` and `base_splat` remove vanished things and add new
ones, and `known_space` computes which part of space was seen.

`store` keeps frames and maps of a session on disk.
"""
