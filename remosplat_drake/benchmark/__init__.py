"""Many trials: scenes, metrics and tables."""
