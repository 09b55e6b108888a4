"""One control tick: control law, quadratic program, decision, verification."""
