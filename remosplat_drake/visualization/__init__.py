"""The Meshcat page: scene, robot and controller as a person sees them.

`MeshcatPage` is the page; `AddViews` adds the systems that draw on it during a
run, and `record_replay` draws a recorded one. Views only look on: they read the
measured configuration and the exported `TickReport`, never an oracle.
Everything lies below `/remosplat` in the page's scene tree.

Two systems on the page send requests: `SafetyPanel` has the stop button,
`TeleopPanel` the controls of an operator. `page_style` defines the look of
controls.
"""
