"""From posed RGB-D images to a splat."""
