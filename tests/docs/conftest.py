"""The hooks that build the documentation, importable as the build does it."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "docs" / "hooks"))
