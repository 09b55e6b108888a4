"""Print the oldest version that pyproject.toml allows of each package.

As a constraints file, it makes pip install those.
"""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

project = tomllib.loads((ROOT / "pyproject.toml").read_text())
extras = project["project"]["optional-dependencies"]
requirements = {
    *project["project"]["dependencies"],
    *(r for extra in extras.values() for r in extra),
    *project["dependency-groups"]["dev"],
}
for requirement in sorted(requirements):
    bound = re.match(r"([\w.-]+)>=([\w.]+)", requirement)
    if bound:
        print(f"{bound[1]}=={bound[2]}")
