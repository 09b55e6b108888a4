"""The closed loop, simulated ahead in compiled steps."""
