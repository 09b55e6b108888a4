"""The page while it is served: its files, and the newest of what it shows."""
