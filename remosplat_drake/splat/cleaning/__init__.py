"""Removal of artefacts from splats that other programs have trained."""
