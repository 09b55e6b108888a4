"""Reads tables by link from YAML files, which may include further tables.

For example, Frankie carries a Panda arm, and its tables include the Panda's
tables with the data of the arm's links.
"""

import dataclasses as dc
from pathlib import Path
from typing import Any, TypeVar

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.ranges import Config, joined
from remosplat_drake.base.strict_yaml import load_strict


@dc.dataclass
class LinkTable(Config):
    """A file with an entry for each link of a robot."""

    # File of the same kind with further links, relative to this file; they come
    # after the links of this file. An included file must not include another
    # one. Empty for none.
    include: str = ""


Table = TypeVar("Table", bound=LinkTable)


def load_link_table(
    schema: type[Table], path: Path, field: str
) -> dict[str, Any]:
    """Reads a table by link, and the table that it includes.

    Args:
        schema: Schema of the file.
        path: The YAML file.
        field: Name of the field that holds the entries by link name.

    Raises:
        FileError: A file is missing or not YAML.
        FieldError: A field is unusable, a link is in both files, or an
            included file includes another.
    """
    file = load_strict(schema, path)
    own: dict[str, Any] = getattr(file, field)
    if not file.include:
        return own
    try:
        source = resources.resolve(file.include, path.parent)
    except FileError as error:
        raise FieldError(str(path), "include", str(error)) from error
    included = load_strict(schema, source)
    if included.include:
        problem = f"{source} must not include a further file"
        raise FieldError(str(path), "include", problem)
    entries: dict[str, Any] = getattr(included, field)
    for link in entries:
        if link in own:
            problem = f"is in {source}, too"
            raise FieldError(str(path), joined(field, link), problem)
    return {**own, **entries}
