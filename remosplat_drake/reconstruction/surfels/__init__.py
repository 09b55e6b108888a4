"""Makes, refines and thins surfels from depth images, without a GPU."""
