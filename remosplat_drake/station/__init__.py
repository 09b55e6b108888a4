"""Stations: the robot behind one set of ports, simulated or real."""
