"""The compiled inner loops of planning."""
