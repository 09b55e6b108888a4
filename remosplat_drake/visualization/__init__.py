"""The Meshcat page, which shows scene, robot and controller in a browser.

`MeshcatPage` is the page; `AddViews` adds the systems that draw on it during a
run, and `record_replay` draws a recorded run. Views do not influence the run:
they only read the measured configuration and the controller's `TickReport`. All
drawn objects are below `/remosplat` in the page's scene tree.

Two systems send a person's requests from the page to the run: `SafetyPanel`
contains the stop button, and `TeleopPanel` an operator's controls. `page_style`
defines the appearance of controls.
"""
