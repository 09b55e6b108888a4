"""Describes the robot's state, and its cause, in one sentence."""
