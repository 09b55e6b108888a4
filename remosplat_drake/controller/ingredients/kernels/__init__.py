"""Kernel that assembles the program of a tick from the ingredients."""
