"""Breaks a robot on a wire in every way, and judges how it stops."""
