"""What the console script makes of errors that no command expects."""

import pytest

from remosplat_drake.commands import scenarios
from remosplat_drake.commands.main import USER_ERROR, main


@pytest.mark.parametrize("detail", ["", "Unable to allocate 3 TiB"])
def test_too_little_memory_is_one_line(monkeypatch, capsys, detail):
    def run(arguments):
        raise MemoryError(detail)

    monkeypatch.setattr(scenarios, "run", run)
    assert main(["scenarios"]) == USER_ERROR
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("remosplat: not enough memory")
    assert detail in error
