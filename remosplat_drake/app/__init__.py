"""The application: builds a scenario's stages into one diagram and runs it.

Read it in this order: `scenario` defines the content of a scenario file,
`world` loads the files that it names, `stages` makes each part, `control_loop`
closes the loop, `diagram` builds the whole diagram, and `simulation` or
`hardware_run` runs it.
"""
