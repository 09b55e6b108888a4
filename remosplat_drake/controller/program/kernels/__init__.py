"""The compiled parts of the program."""
