"""The oracle alone: the distance of each link of a robot from a splat.

It needs no Drake diagram and no scenario, only a robot, a map and one query.
"""

import remosplat_drake as rs

SPLAT = "package://remosplat_drake/models/scenes/table/splat.ply"


def main() -> None:
    """Prints the clearance of every link."""
    robot = rs.load_robot("frankie", floor_height=0.03)
    field = rs.SphereToEllipsoid().make(rs.read_splat(SPLAT))
    clearances = field.clearances(robot.spheres_at(robot.q_home))

    nearest: dict[str, float] = {}
    for sphere, distance in zip(
        clearances.sphere, clearances.distance, strict=True
    ):
        link = robot.spheres.links[sphere]
        nearest[link] = min(distance, nearest.get(link, float("inf")))
    for link, distance in sorted(nearest.items(), key=lambda item: item[1]):
        print(f"{link:18} {1e3 * distance:7.1f} mm")
    print(f"smallest: {1e3 * clearances.minimum():.1f} mm")


if __name__ == "__main__":
    main()
