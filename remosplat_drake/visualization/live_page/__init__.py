"""The page while it is served: its files, and its newest content."""
