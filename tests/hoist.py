"""The Panda's hand on a hoist: the least robot that lifts things."""

from pathlib import Path

from remosplat_drake.robot.robot_model import RobotModel, load_robot

DATA = Path(__file__).resolve().parent / "data"


def load_hoist(folder: Path) -> RobotModel:
    """Loads it, from a folder where its files get the path of their parts."""
    for name in ("hoist.yaml", "hoist.dmd.yaml", "hoist_spheres.yaml"):
        text = (DATA / name).read_text().replace("DATA", str(DATA))
        (folder / name).write_text(text)
    return load_robot(folder / "hoist.yaml")
