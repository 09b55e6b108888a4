"""The Meshcat page: what a person sees of scene, robot and controller.

Views only look on: they read the measured configuration and the exported
`TickReport`, never an oracle. Everything lies below `/remosplat` in the
page's scene tree.
"""
