"""How things stand with the robot: one sentence, and what is behind it."""
