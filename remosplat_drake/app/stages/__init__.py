"""Makes each stage of the application from a scenario.

What a stage needs of others are its arguments; `control_loop` and `diagram`
wire them together.
"""
