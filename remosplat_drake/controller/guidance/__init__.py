"""Guidance: chooses a way around obstacles by rollouts.

The program of a tick is local, so the robot stalls if an obstacle is between
end effector and target. A `Guidance` modifies the tick: it steers to one side,
weakens the cost on proximity, or allows a smaller stopping distance. The
selector simulates a few of these candidates on the known map, and follows one
that arrives.
"""
