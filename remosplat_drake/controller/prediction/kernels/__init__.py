"""The compiled forms of what is remembered and predicted."""
