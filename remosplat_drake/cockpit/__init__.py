"""The cockpit: an operator's page, on viser, in a separate process.

In the control process, `cockpit_process` starts the page's process and
communicates with it. `CockpitView` sends the robot's state to the page, and
`CockpitOperator` outputs the operator's requests. In the page's process,
`server` serves the page. There, `scene` draws, `client_panel` makes the
controls of one browser, `authority` decides which browser operates the robot,
and `operator_input` stores the requests. `reach` and `surface_point` are pure
functions.
"""
