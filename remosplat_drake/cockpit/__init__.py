"""The cockpit: an operator's page, on viser, in a separate process.

In the control process, `cockpit_process` starts the page's process and
communicates with it. `CockpitView` sends it the robot's state, and
`CockpitOperator` outputs the requests of its operator. In the page's process,
`server` serves the page: `scene` draws, `client_panel` has the controls of one
browser, `authority` decides which browser operates, and `operator_input` stores
the requests. `reach` and `surface_point` are pure functions.
"""
