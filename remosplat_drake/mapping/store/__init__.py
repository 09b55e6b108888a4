"""A session on disk: its frames, its maps and where they lie."""
