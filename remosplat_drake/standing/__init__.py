"""The robot's state in one sentence, with its causes."""
