"""`saved_page`: adds bar, panel and player to a static Meshcat page."""

import json
from collections.abc import Mapping
from typing import Any

from remosplat_drake.visualization.live_page.page_files import (
    resource,
    with_panel,
)


def saved_page(page: str, topics: Mapping[str, Any]) -> str:
    """Adds the content of bar, panel and player to a static page.

    Args:
        page: The page from `Meshcat.StaticHtml`.
        topics: Content of the page, keyed as in `web/panel.js`. A value is None
            if the page has no such content.
    """
    told = {name: value for name, value in topics.items() if value is not None}
    # In the JSON, "<" is escaped, so that it cannot end the surrounding script.
    data = json.dumps(told).replace("<", "\\u003c")
    return with_panel(page, f"const told = {data};", resource("saved.js"))
