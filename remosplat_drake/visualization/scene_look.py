"""`dress`: adds sky, floor and light to a scene."""

from pydrake.geometry import Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform

ROOT = "/remosplat"
"""Path in the scene tree that contains all objects of this package."""

LIVE = f"{ROOT}/live"
"""Path in the scene tree of objects that a recording cannot contain. A replay
hides them."""

_FLOOR_RADIUS = 30.0
_FLOOR_DROP = 0.006  # A captured floor must not fight with the drawn one.
_CAMERA = "/Cameras/default/rotated/<object>"
_SKY = [0.94, 0.96, 0.98]
_NADIR = [0.50, 0.52, 0.54]
_FLOOR = Rgba(0.70, 0.73, 0.77)
_LIGHTS = {
    "AmbientLight": {"intensity": 0.7},
    "PointLightNegativeX": {"visible": False},
    "PointLightPositiveX": {"visible": False},
    # The sun is above and behind the default camera. It is the only light with
    # a shadow.
    "FillLight": {
        "position": [-4.5, -2.2, 7.0],
        "intensity": 2.3,
        "castShadow": True,
        "shadow.radius": 4.0,
        "shadow.bias": -0.0005,
        "shadow.normalBias": 0.01,
        "shadow.mapSize.width": 2048.0,
        "shadow.mapSize.height": 2048.0,
    },
}


def dress(meshcat: Meshcat, *, floor: bool) -> None:
    """Gives an empty scene a sky, a floor, light and shadows.

    Args:
        meshcat: The Meshcat server.
        floor: Whether to draw a floor.
    """
    meshcat.SetProperty("/Background/<object>", "top_color", _SKY)
    meshcat.SetProperty("/Background/<object>", "bottom_color", _NADIR)
    meshcat.SetProperty("/Background/<object>", "render_environment_map", False)
    for path in ("/Grid", "/Axes"):
        meshcat.SetProperty(path, "visible", False)
    for light, properties in _LIGHTS.items():
        for name, value in properties.items():
            node = f"/Lights/{light}"
            # Visibility is a property of the path in the tree; the other
            # properties belong to the light object.
            if name != "visible":
                node += "/<object>"
            meshcat.SetProperty(node, name, value)
    meshcat.SetProperty(_CAMERA, "zoom", 2.2)
    if floor:
        path = f"{ROOT}/floor"
        meshcat.SetObject(path, Cylinder(_FLOOR_RADIUS, 0.01), _FLOOR)
        meshcat.SetTransform(
            path, RigidTransform([1.0, 0.0, -0.005 - _FLOOR_DROP])
        )
