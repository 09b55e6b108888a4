"""Makes each stage of the application from a scenario.

The arguments of a stage are output ports of other stages; `control_loop` and
`diagram` connect the stages.
"""
