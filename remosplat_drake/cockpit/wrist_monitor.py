"""`WristMonitor`: shows the wrist camera's image with a crosshair."""

import numpy as np
import viser

from remosplat_drake.capture.frames import Frame

_ARM = 0.06
"""Length of the crosshair's arms, as a fraction of the picture's height."""

_PATCH = 0.02
"""Half the side of the central square whose distance is shown, as a fraction of
the picture's height."""


class WristMonitor:
    """Shows the wrist camera's image, and the distance ahead of it.

    Args:
        server: The page's server.
    """

    def __init__(self, server: viser.ViserServer):
        self._server = server
        self._image: viser.GuiImageHandle | None = None

    def show(self, frame: Frame) -> None:
        """Shows a picture.

        Args:
            frame: The picture.
        """
        text = ahead_of(frame.depth)
        if self._image is None:
            gui = self._server.gui
            with gui.add_folder("Wrist camera", order=6.0):
                self._text = gui.add_html(text)
                self._image = gui.add_image(
                    with_crosshair(frame.rgb), format="jpeg", jpeg_quality=60
                )
            return
        with self._server.atomic():
            self._image.image = with_crosshair(frame.rgb)
            if self._text.content != text:
                self._text.content = text


def with_crosshair(rgb: np.ndarray) -> np.ndarray:
    """Returns a picture with a crosshair in its middle.

    Args:
        rgb: The picture, shape (h, w, 3), uint8.
    """
    height, width = rgb.shape[:2]
    middle, arm = (height // 2, width // 2), max(2, round(_ARM * height))
    marked = rgb.copy()
    for rows, columns in ((1, arm), (arm, 1)):
        part = (
            slice(middle[0] - rows, middle[0] + rows + 1),
            slice(middle[1] - columns, middle[1] + columns + 1),
        )
        # The inverted colours are visible on any background.
        marked[part] = 255 * (rgb[part].mean(axis=2, keepdims=True) < 128)
    return marked


def ahead_of(depth: np.ndarray) -> str:
    """Formats the distance in the middle of a picture, as HTML.

    Args:
        depth: Depth, shape (h, w) [m]; 0 where unknown.
    """
    height, width = depth.shape
    half = max(1, round(_PATCH * height))
    patch = depth[
        height // 2 - half : height // 2 + half + 1,
        width // 2 - half : width // 2 + half + 1,
    ]
    known = patch[np.isfinite(patch) & (patch > 0)]
    far = f"{np.median(known):.2f} m ahead" if len(known) else "nothing ahead"
    return f'<div style="padding:0 12px;font-size:15px">{far}</div>'
