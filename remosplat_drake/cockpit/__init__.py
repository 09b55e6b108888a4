"""The cockpit: an operator's page, on viser, in a separate process.

`cockpit_process` is the control process's end of it. `CockpitView` sends it
the robot's state, and `CockpitOperator` outputs the requests of its operator.
Inside the process `server` serves the page: `scene` draws, `client_panel`
has the controls of one browser, `authority` decides which browser operates,
and `desk` stores the requests. `reach` and `surface_point` are pure.
"""
