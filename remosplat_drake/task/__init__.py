"""The task: targets, and when one has been reached."""
