"""One reader for each way in which RGB-D captures are stored."""
