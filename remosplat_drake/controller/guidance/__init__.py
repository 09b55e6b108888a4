"""Guidance: simulates rollouts to choose a way around obstacles.

The quadratic program of a tick considers only the present state, so the robot
stalls if an obstacle is between the end effector and the target. A `Guidance`
modifies the tick: it steers the robot to one side, reduces the cost of
proximity, or allows a smaller stopping distance. The `GuidanceSelector`
simulates several candidates on the known map (rollouts), and selects one that
reaches the target.
"""
