"""The application: a scenario's stages, wired into one diagram and run.

Read it from top to bottom: `scenario` is what a file may say, `world` what its
files hold, `stages` how each part is made, `control_loop` how they close the
loop, `diagram` the whole, `simulation` and `hardware_run` what runs it.
"""
