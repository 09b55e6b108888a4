"""Posed RGB-D images: the type, its file formats, checks and sources."""
