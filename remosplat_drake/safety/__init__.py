"""Safety: the supervisor that stops the robot, and gates before it starts.

`SafetySupervisor` stands between controller and station. Once a control
period it looks for `symptoms`: stale or frozen measurements, a reflex or a
protective stop, a late control tick, a command that is not followed, too
little clearance. Any of them ramps the robot down into a latched stop, which
only a release ends. `supervise` is that state machine as a pure function.

`gates` is about runs that have not begun: properties of a map that must be
known, or accepted by name, before a robot moves.
"""
