"""The compiled forms of history and prediction."""
