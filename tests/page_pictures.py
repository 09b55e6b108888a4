"""Pictures of a page at three sizes, compared with those in the docs.

`make pictures` takes them again. Fonts and renderers differ between computers,
so that pictures are compared in blocks of some pixels, and with tolerances.
"""

import dataclasses as dc
import io
import os
from pathlib import Path

import numpy as np
from browser import Browser
from PIL import Image

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images" / "states"

SIZES = (1280, 800), (820, 1180), (390, 844)
"""A screen, an upright tablet and an upright telephone [px]."""

SCALE = 0.5
"""Pixels of a picture for a pixel of the page."""

_RETAKE = "RETAKE_PICTURES" in os.environ

_BLOCK = 8
"""Side of the blocks that are compared [px of the picture]."""

_OFF = 40.0
"""Difference of the mean colours of two blocks that do not look alike, of
255."""

FEW = 0.08
"""Greatest share of such blocks in two pictures of the same state. Pictures of
different states differ in more than a tenth of theirs."""

_TRIES = 3
"""Pictures of a page that may still be changing."""

_GAP = 16
"""Space between two pictures of a sheet [px]."""

_DRAWN = """(() => {
  window.frames_drawn = 0;
  window.draws = true;
  const count = () => {
    frames_drawn += 1;
    if (frames_drawn < 3) requestAnimationFrame(count);
  };
  requestAnimationFrame(count);
})()"""

_AGELESS = """(() => {
  const style = document.createElement("style");
  style.textContent = "#age, .mantine-Notification-root"
    + " { display: none !important; }"
    + "* { transition: none !important; caret-color: transparent !important; }";
  document.head.append(style);
})()"""
"""While pictures are taken, nothing moves, and the page would state its age.
viser warns of software that draws."""

TEXTS = """(() => {
  const wrong = [];
  const all = [...document.querySelectorAll("body *")];
  for (const e of all) {
    const own = [...e.childNodes].filter((n) => n.nodeType === 3);
    if (!own.some((n) => n.textContent.trim())) continue;
    const style = getComputedStyle(e);
    if (style.visibility === "hidden" || style.opacity === "0") continue;
    const range = document.createRange();
    for (const node of own) {
      range.selectNodeContents(node);
      for (const r of range.getClientRects()) {
        if (r.width < 1 || r.height < 1) continue;
        const text = node.textContent.trim();
        if (r.left < -1 || r.right > innerWidth + 1) {
          wrong.push("outside: " + text);
        }
        // The nearest ancestor that cuts off what sticks out of it.
        let box = e;
        while (box && getComputedStyle(box).overflowX === "visible") {
          box = box.parentElement;
        }
        if (!box || box === document.documentElement) continue;
        const around = box.getBoundingClientRect();
        if (r.right > around.right + 1 || r.left < around.left - 1) {
          wrong.push("cut off: " + text);
        }
      }
    }
  }
  return [...new Set(wrong)];
})()"""
"""Texts that are outside of the window or cut off, to the left or right."""


@dc.dataclass(frozen=True, eq=False)
class Gallery:
    """Takes pictures of a page in its states.

    Attributes:
        tab: The tab that shows the page.
        prefix: Beginning of the pictures' names.
    """

    tab: Browser
    prefix: str

    def take(self, state: str) -> None:
        """Compares the page's look at all sizes with the kept one.

        Args:
            state: Name of the page's state.
        """
        path, share = FOLDER / f"{self.prefix}_{state}.webp", 1.0
        for _ in range(_TRIES):
            sheet = _sheet([self._look(size) for size in SIZES])
            if _RETAKE:
                FOLDER.mkdir(exist_ok=True)
                sheet.save(path, quality=75, method=6)
            share = unlike(sheet, Image.open(path))
            if share <= FEW:
                return
        raise AssertionError(f"{100 * share:.0f} % of {path.name} differ")

    def _look(self, size: tuple[int, int]) -> Image.Image:
        width, height = size
        tab = self.tab
        tab.show_as(width, height, mobile=width < 1000, scale=SCALE)
        tab.wait_for(f"innerWidth == {width} && innerHeight == {height}")
        tab.evaluate(_AGELESS)
        tab.evaluate(_DRAWN)
        tab.wait_for("frames_drawn >= 3 && !window.viewer?.needs_render")
        tab.evaluate("window.draws = false")
        assert tab.evaluate(TEXTS) == []
        return Image.open(io.BytesIO(tab.picture())).convert("RGB")


def unlike(sheet: Image.Image, kept: Image.Image) -> float:
    """The share of blocks in which two sheets do not look alike.

    It is that of the size at which they differ most.
    """
    assert sheet.size == kept.size, (sheet.size, kept.size)
    shares = []
    for box in _boxes():
        a, b = (
            _blocks(each.convert("RGB").crop(box)) for each in (sheet, kept)
        )
        shares.append(float((np.abs(a - b).max(axis=2) > _OFF).mean()))
    return max(shares)


def darkness(tab: Browser) -> float:
    """The share of a page that is nearly black."""
    picture = Image.open(io.BytesIO(tab.picture())).convert("RGB")
    return float((np.asarray(picture).max(axis=2) < 40).mean())


def _blocks(picture: Image.Image) -> np.ndarray:
    """The mean colours of blocks."""
    size = picture.width // _BLOCK, picture.height // _BLOCK
    small = picture.resize(size, Image.Resampling.BOX)
    return np.asarray(small, float)


def _boxes() -> list[tuple[int, int, int, int]]:
    """Where the pictures of all sizes are in a sheet [px]."""
    sizes = [(round(SCALE * w), round(SCALE * h)) for w, h in SIZES]
    left = np.cumsum([0, *(w + _GAP for w, _ in sizes)]).tolist()
    return [(x, 0, x + w, h) for x, (w, h) in zip(left, sizes, strict=False)]


def _sheet(pictures: list[Image.Image]) -> Image.Image:
    """The pictures beside each other."""
    boxes = _boxes()
    size = boxes[-1][2], max(box[3] for box in boxes)
    sheet = Image.new("RGB", size, "white")
    for box, picture in zip(boxes, pictures, strict=True):
        sheet.paste(picture, box)
    return sheet
