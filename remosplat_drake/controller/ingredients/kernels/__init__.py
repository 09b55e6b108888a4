"""How the ingredients are put together."""
