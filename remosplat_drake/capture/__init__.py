"""Posed RGB-D images: the type, how it is read, checked and rendered."""
