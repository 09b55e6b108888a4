"""A robot's own files, made into a description of ours."""
