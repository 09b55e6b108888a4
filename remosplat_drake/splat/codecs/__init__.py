"""One reader and writer for each format of splat files."""
