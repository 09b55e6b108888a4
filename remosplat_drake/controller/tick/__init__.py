"""One control tick: the law, the program, the decision, verification."""
