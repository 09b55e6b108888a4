"""Simulated stations: the robot behind one set of ports."""
