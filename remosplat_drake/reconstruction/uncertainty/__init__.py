"""How wrong the discs of a splat may be, and where no disc is."""
