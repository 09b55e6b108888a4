"""The Meshcat page, which shows scene, robot and controller in a browser.

`MeshcatPage` is the page; `AddViews` adds the systems that draw on it during a
run, and `record_replay` draws a recorded one. Views do not influence the run:
they read the measured configuration and the controller's `TickReport`, and
query no oracle. All drawn objects are below `/remosplat` in the page's scene
tree.

Two systems on the page send requests: `SafetyPanel` has the stop button,
`TeleopPanel` the controls of an operator. `page_style` defines the look of
controls.
"""
