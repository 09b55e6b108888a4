"""Posed RGB-D images: their data type, readers, checks and rendering."""
