"""What cameras see move: from depth images to `Movers`."""
