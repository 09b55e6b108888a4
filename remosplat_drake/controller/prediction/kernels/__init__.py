"""Compiled functions of the history and of the prediction."""
