"""The reference's pages, written from the code while the site is built."""

import inspect

from command_flags import reference_of_commands
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from scenario_fields import reference_of

import remosplat_drake
from remosplat_drake.app.scenario import Scenario

SCENARIO = """# Scenario fields

A scenario file is a mapping of names to scenarios, as [its
guide](../guides/scenarios.md) tells. Every field has a default, so a scenario
says only what differs. Below are all fields, dataclass by dataclass, beginning
with the scenario itself; brackets that are round leave the bound out.

"""

COMMANDS = """# Commands

`remosplat COMMAND --help` says the same. Exit codes are 0 for done, 1 where
the robot did not get there, 2 where something in the input has to be mended
(one line says what and where), and 130 when interrupted.

"""

API = """# The public API

`import remosplat_drake as rs` gives these names, and loads what stands behind
one of them only when it is used.

"""


def reference_of_api() -> str:
    """Markdown from which mkdocstrings makes the page of public names."""
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
"""What each generated page is made by."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Mkdocs asks once, before it reads any page."""
    for path, make in PAGES.items():
        files.append(File.generated(config, path, content=make()))
    return files
