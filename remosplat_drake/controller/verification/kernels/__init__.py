"""The compiled inner loops of verification."""
