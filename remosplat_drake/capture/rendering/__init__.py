"""Synthetic captures: RGB-D images of known scenes, rendered by Drake."""
