"""What a run leaves behind: its trajectory and the numbers about it."""
