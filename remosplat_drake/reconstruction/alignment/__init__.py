"""Refinement of camera poses and of the camera's own errors."""
