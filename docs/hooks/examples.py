"""A Griffe extension that shows the examples in docstrings as code.

mkdocstrings supports the heading "Examples:" only. It would show a section
"Example:" as a quotation.
"""

import re
from typing import Any

from griffe import Extension, Object

_HEADING = re.compile(r"^Example:$", re.M)


def with_examples(docstring: str) -> str:
    """Renames the heading "Example:" in a docstring to "Examples:"."""
    return _HEADING.sub("Examples:", docstring)


class Examples(Extension):
    """An extension that Griffe calls for every documented object."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Renames the heading in the docstring of an object."""
        if obj.docstring is not None:
            obj.docstring.value = with_examples(obj.docstring.value)
