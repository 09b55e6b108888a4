"""Posed RGB-D images: data type, readers, checks and rendering."""
