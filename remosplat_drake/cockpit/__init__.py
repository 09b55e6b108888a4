"""The cockpit: an operator's page, on viser, in a separate process.

`cockpit_process` is the control process's end of it. `CockpitView` tells it
the robot's state, `CockpitOperator` asks what its operator wishes for.
Inside the process `server` serves the page: `scene` draws, `client_panel`
has the controls of one browser, `authority` knows which of them operates,
and `desk` keeps what that one has asked for. `reach` and `surface_point` are
pure.
"""
