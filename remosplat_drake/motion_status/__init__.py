"""Describes the robot's state in one sentence, with the cause."""
