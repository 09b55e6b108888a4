"""Removes artefacts from splats that other programs have trained."""
