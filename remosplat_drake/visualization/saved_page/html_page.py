"""`saved_page`: a static page of Meshcat with what was shown beside it."""

import json
from collections.abc import Mapping
from typing import Any

from remosplat_drake.visualization.live_page.page_files import (
    resource,
    with_panel,
)


def saved_page(page: str, topics: Mapping[str, Any]) -> str:
    """Adds to a static page what its server has shown beside the scene.

    Args:
        page: The page, as `Meshcat.StaticHtml` has made it.
        topics: What the panel shows, by its names in `web/panel.js`; None
            for what there is not.
    """
    told = {name: value for name, value in topics.items() if value is not None}
    # JSON that cannot end the script in which it stands.
    data = json.dumps(told).replace("<", "\\u003c")
    return with_panel(page, f"const told = {data};", resource("saved.js"))
