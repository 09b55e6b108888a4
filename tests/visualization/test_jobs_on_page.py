"""`remosplat teleop` with objects, on Meshcat's page in a real browser."""

import signal
import subprocess

import pytest
from browser import find_chromium, open_browser
from patience import PATIENCE
from runs import address, command_line

from remosplat_drake.recording.run_log import read_log
from remosplat_drake.recording.trajectory_log import LOG


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_an_operator_takes_a_can_and_puts_it_on_the_tray(tmp_path, frankie):
    session = tmp_path / "session"
    command = command_line(
        *("teleop", "TableObjects", "--session", session),
        *("--viewer", "meshcat"),
    )
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            with open_browser((1400, 900)) as tab:
                tab.draw_nothing()
                tab.listen_to_console()
                tab.open(address(process))
                operate(tab, tmp_path)
                assert tab.console() == []
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        finally:
            process.kill()
    q = read_log(session / "runs" / "0001" / LOG).rows["q"][-1]
    # The hand has retreated from the tray, and not gone anywhere else.
    assert frankie.end_effector_pose(q)[1, 3] > 0.5


def operate(tab, folder):
    """Takes the can, gives a place up, and places it."""
    tab.wait_for("document.querySelectorAll('.remosplat-take').length == 4")
    choose(tab, "soup can")
    press(tab, "Take it")
    present = "document.querySelector('#task [aria-current]')?.innerText ?? ''"
    tab.wait_for(f"{present} == 'pick the soup can'")
    tab.wait_for("document.querySelectorAll('#task li[data-step]').length == 5")
    tab.save_picture(folder / "takes.png")
    target = "document.querySelector('[data-topic=target]').innerText"
    tab.wait_for(f"{target}.includes('hold: pick the soup can: done')")
    choose(tab, "tray")
    press(tab, "Put the soup can there")
    tab.wait_for(f"{target}.includes('carries the soup can')")
    press(tab, "Give up")
    failures = "document.querySelector('#task em')?.innerText ?? ''"
    tab.wait_for(f"{failures} == 'the operator ended the job'")
    press(tab, "Put the soup can there")
    tab.wait_for(f"{target}.includes('hold: place the soup can: done')")
    tab.save_picture(folder / "placed.png")


def choose(tab, name: str):
    """Chooses an object of the list."""
    pressed = "document.querySelector('#task [aria-pressed=true]')"
    click(tab, f"#task button[data-object='{name}']", name)
    tab.wait_for(f"{pressed}?.dataset.object == '{name}'")


def press(tab, label: str):
    """Clicks a button below the list."""
    click(tab, "#task button[data-action]", label)


def click(tab, selector: str, text: str):
    """Scrolls to a button and clicks it."""
    buttons = f'[...document.querySelectorAll("{selector}")]'
    found = f"{buttons}.find(b => b.innerText.includes('{text}'))"
    tab.wait_for(f"!!{found}")
    tab.evaluate(f"{found}.scrollIntoView({{ block: 'center' }})")
    tab.click(selector, text=text)
