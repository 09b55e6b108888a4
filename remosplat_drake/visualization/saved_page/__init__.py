"""The page as one file: compressed, with a player and the measurements."""
