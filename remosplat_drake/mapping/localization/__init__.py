"""Localisation of the base at the times of frames.

The odometry of a base drifts, but the surfaces in camera images do not move.
Each frame is a keyframe of a graph (`keyframe_graph`). Odometry connects it
with the previous keyframe. Shared surfaces connect it with all keyframes that
show them, recent or old, so that loops are closed. `FrameAligner` keeps the
graph from map to map, and reports frames that do not fit.
"""
