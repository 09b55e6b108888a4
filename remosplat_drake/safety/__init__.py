"""The supervisor: what stops the robot, and the gates before it starts."""
