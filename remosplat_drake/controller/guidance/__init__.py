"""Guidance: which way round an obstacle, chosen by looking ahead.

The program of a tick is local and stalls where the hand is pressed against
something between it and its target. A guidance bends the tick: towards one
side, with less appetite for clearance, closer to the scene. The selector
tries a few of them on the known map, ahead of time, and keeps what arrives.
"""
