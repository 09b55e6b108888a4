"""Moving objects of a simulation, as functions of time."""
