"""What does not belong into a splat that another program has trained."""
