"""Makes each stage of the application from a scenario.

The arguments of a stage are the outputs of others that it needs; `control_loop`
and `diagram` connect them.
"""
