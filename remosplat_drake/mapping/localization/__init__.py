"""Localisation of the base at the times of frames.

A base's odometry drifts; camera images of the map do not. Each frame is a
keyframe of a graph (`keyframe_graph`): odometry connects it with the previous
one, and shared surfaces connect it with all frames that show them, recent or
old, which closes loops. `FrameAligner` keeps the graph from map to map and
reports frames that do not fit.
"""
