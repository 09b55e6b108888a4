"""Objects of a scene that a hand may take, carry and put down."""
