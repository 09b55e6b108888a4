"""What moves by itself in a simulation, as functions of time."""
