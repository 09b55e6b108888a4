"""Safety: a supervisor that stops the robot, and gates before a run starts.

`SafetySupervisor` receives the controller's commands, and passes them on to the
station. Once per control period it checks for `symptoms`: stale measurements, a
reflex or a protective stop, a late control tick, a command that the robot does
not follow, or a clearance that is too small. If it finds a symptom, it brakes
the robot along the braking ramp. The stop is latched, so only a release ends
it. The function `supervise` is the state machine of the supervisor.

The module `gates` permits or refuses a run before it begins. If a check of the
map or of the start pose fails, a person must accept this fault by its name
before a robot moves.
"""
