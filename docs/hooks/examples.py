"""An example in a docstring is shown as code, as Google's style has it.

mkdocstrings knows the section "Examples:" only; "Example:" would be a box of
quotations.
"""

import re
from typing import Any

from griffe import Extension, Object

_HEADING = re.compile(r"^Example:$", re.M)


def with_examples(docstring: str) -> str:
    """A docstring whose example is a section."""
    return _HEADING.sub("Examples:", docstring)


class Examples(Extension):
    """Griffe asks for every object with a docstring."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Renames the heading."""
        if obj.docstring is not None:
            obj.docstring.value = with_examples(obj.docstring.value)
