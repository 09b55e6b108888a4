"""The page as one file: compressed, with a player and what was measured."""
