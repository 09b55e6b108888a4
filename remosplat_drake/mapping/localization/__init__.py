"""Where the base really was when frames were taken.

A base's odometry drifts; what its camera sees of the map does not. Each frame
is a keyframe of a graph (`keyframe_graph`): odometry joins it with the one
before, shared surfaces with any that see them, near or long ago, and so loops
close. `FrameAligner` keeps the graph from map to map and says which frames it
cannot explain.
"""
