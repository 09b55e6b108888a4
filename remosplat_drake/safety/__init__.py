"""Safety: the supervisor that stops the robot, and gates before it starts.

`SafetySupervisor` receives the controller's commands, and passes them on to the
station. Once a control period it checks for `symptoms`: stale or frozen
measurements, a reflex or a protective stop, a late control tick, a command that
is not followed, too little clearance. If it finds one, it brakes the robot
along the braking ramp. The stop is latched: only a release ends it. `supervise`
is that state machine as a pure function.

`gates` checks a run before it begins: properties of map and start pose that
must be good, or accepted by name, before a robot moves.
"""
