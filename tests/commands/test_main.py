"""Messages of the console script about errors that no command expects."""

import pytest

from remosplat_drake.commands import scenarios
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.commands.unexpected import SHOW_TRACEBACK
from remosplat_drake.splat import formats


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


def test_an_interrupt_that_compiled_code_reports_is_one(monkeypatch, capsys):
    def run(arguments):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interrupt:
            raise SystemError("returned a result") from interrupt

    monkeypatch.setattr(scenarios, "run", run)
    assert main(["scenarios"]) == 130
    assert capsys.readouterr().err == "remosplat: interrupted\n"


def test_another_system_error_keeps_its_traceback(monkeypatch):
    def run(arguments):
        raise SystemError("returned a result")

    monkeypatch.setattr(scenarios, "run", run)
    with pytest.raises(SystemError, match="returned a result"):
        main(["scenarios"])


@pytest.fixture
def state(tmp_path, monkeypatch):
    """The user's folder for logs."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.delenv(SHOW_TRACEBACK, raising=False)
    return tmp_path / "state" / "remosplat_drake"


@pytest.fixture
def defect(tmp_path, monkeypatch):
    """A splat reader that fails where it should not."""

    def a_defect_of_ours(path, start):
        raise ValueError("two\nlines")

    monkeypatch.setattr(formats, "_format_of_zip", a_defect_of_ours)
    (tmp_path / "some.ply").write_bytes(b"no PLY")
    return ["convert", str(tmp_path / "some.ply"), str(tmp_path / "new.ply")]


def test_a_reader_without_an_answer_is_one_line(state, defect, capsys):
    assert main(defect) == USER_ERROR
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith(f"remosplat: could not read {defect[1]}: Value")
    (log,) = (state / "tracebacks").iterdir()
    assert f"the traceback is in {log};" in error
    text = log.read_text()
    assert "a_defect_of_ours" in text
    assert "Traceback" in text
    # The same defect fills no disk.
    assert main(defect) == USER_ERROR
    assert list((state / "tracebacks").iterdir()) == [log]


def test_a_programmer_sees_the_traceback(state, defect, capsys, monkeypatch):
    monkeypatch.setenv(SHOW_TRACEBACK, "1")
    assert main(defect) == USER_ERROR
    error = capsys.readouterr().err
    assert "a_defect_of_ours" in error
    assert error.splitlines()[-1].startswith("remosplat: could not read")


def test_without_a_log_the_traceback_is_printed(state, defect, capsys):
    state.parent.write_text("a file is where the folder should be")
    assert main(defect) == USER_ERROR
    error = capsys.readouterr().err
    assert "a_defect_of_ours" in error
    assert "no log of the traceback could be written" in error


def test_what_fails_beyond_reading_keeps_its_traceback(monkeypatch, state):
    """A robot that is driven, for example."""

    def run(arguments):
        raise ValueError("a defect")

    monkeypatch.setattr(scenarios, "run", run)
    with pytest.raises(ValueError, match="a defect"):
        main(["scenarios"])
    assert not state.exists()


def test_names_cannot_break_the_line(capsys):
    name = "a\nb\x1b[31m\ud800" + "x" * 10**4 + ".ply"
    assert main(["convert", name, "other.ply"]) == USER_ERROR
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "\x1b" not in error
    assert r"a\nb\x1b[31m\ud800xx" in error
    assert len(error) < 3000
