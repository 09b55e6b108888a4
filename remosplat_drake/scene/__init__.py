"""Scenes of known geometry, the ground truth of benchmarks and tests."""
