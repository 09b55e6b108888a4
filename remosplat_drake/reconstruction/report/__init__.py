"""How far a splat can be trusted, measured and told."""
