"""Acceptance tests: inject faults into a robot on LCM, and judge its stops."""
