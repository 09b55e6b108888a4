"""The Meshcat page."""
