"""Costs and constraints of the program, one class a file."""
