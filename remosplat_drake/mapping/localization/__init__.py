"""Localises the mobile base at the times of camera frames.

The odometry of a base drifts, but the surfaces in camera images do not move.
Each frame is a keyframe of a graph (`keyframe_graph`). Odometry connects it
with the previous keyframe. Shared surfaces connect it with all keyframes that
show the same surfaces, recent or old, so that loops are closed. `FrameAligner`
stores the graph between maps, and reports frames that do not fit.
"""
