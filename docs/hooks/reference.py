"""Generation of the pages of the reference from the code, in each build."""

import inspect

from command_flags import reference_of_commands
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from scenario_fields import reference_of

import remosplat_drake
from remosplat_drake.app.scenario import Scenario

SCENARIO = """# Scenario fields

This page lists all fields of a scenario file. [The guide to
scenarios](../guides/scenarios.md) explains these files. A field that is left
out has its default value. Each section describes one dataclass, beginning with
the scenario itself. In the column of ranges, a square bracket includes the
bound, and a round bracket excludes it.

"""

COMMANDS = """# Commands

This page lists all commands with their arguments, as
`remosplat COMMAND --help` prints them. The exit code is 0 for success, 1 if the
robot did not reach its targets or a check failed, 2 after an error in the
input, which one line describes, and 130 after Ctrl-C.

"""

API = """# The public API

This page lists the public names of the package. `import remosplat_drake as rs`
provides these names. The module of a name is loaded when the name is first
used.

"""


def reference_of_api() -> str:
    """Returns Markdown from which mkdocstrings makes the page of the API."""
    public = [name for name in remosplat_drake.__all__ if name[0] != "_"]
    return "\n".join(map(_entry, public))


def _entry(name: str) -> str:
    thing = getattr(remosplat_drake, name)
    module = inspect.getmodule(thing)
    home = module.__name__ if module else "remosplat_drake"
    path = getattr(thing, "__qualname__", name)
    return f"::: {home}.{path}\n    options: {{heading_level: 2}}\n"


PAGES = {
    "reference/scenario.md": lambda: SCENARIO + reference_of(Scenario),
    "reference/commands.md": lambda: COMMANDS + reference_of_commands(),
    "reference/api.md": lambda: API + reference_of_api(),
}
"""The paths of the generated pages, each with the function that makes it."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the generated pages; MkDocs calls this before it reads any page."""
    for path, make in PAGES.items():
        files.append(File.generated(config, path, content=make()))
    return files
