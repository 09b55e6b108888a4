"""The live map: builds maps from frames of the wrist camera during a run.

`LiveMap` is the system in the diagram. It sends requests to a `MappingProcess`,
and replaces the map in use by the maps that this process builds. It never waits
for the process. In the process, `worker` takes pictures and builds maps, with
the inputs of its `MappingJob`. `messages` defines the messages between the two
processes.

`map_builder.build_map` builds a map. `changes` finds the parts of frames that
newer frames contradict. `carving` and `base_splat` remove vanished objects and
add new ones. `known_space` computes the part of space that was seen.

`store` keeps frames and maps of a session on disk.
"""
