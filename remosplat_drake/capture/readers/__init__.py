"""Readers of RGB-D captures, one for each format in which they are stored."""
