"""Reports on how far a splat can be trusted: measured, drawn and told."""
