"""Detection of moving objects: from depth images to `Movers`."""
