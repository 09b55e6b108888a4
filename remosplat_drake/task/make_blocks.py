"""`make_blocks`: converts the steps of a scenario to the blocks of a task."""

import dataclasses as dc
import math
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.pose_config import PoseConfig, make_transform
from remosplat_drake.base.ranges import joined
from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot import planar_pose
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.task import step_configs as cfg
from remosplat_drake.task.step import (
    AT,
    ATTACH,
    BASE_TO,
    BY_HAND,
    BY_WORLD,
    OBJECT_TO,
    ON_OBJECT,
    RELEASE,
    Block,
    Goal,
    Step,
)
from remosplat_drake.task.workshop import Workshop

_ROUNDING = 0.001
"""Two shapes in contact may overlap by this length because of rounding [m]."""


def carried_objects(configs: Sequence[cfg.AnyStep]) -> tuple[str, ...]:
    """Returns the names of the objects that the robot carries in some steps.

    Args:
        configs: The steps.
    """
    names = [
        each.object
        for each in configs
        if isinstance(each, (cfg.Attach, cfg.Pick, cfg.TakeOver))
    ]
    return tuple(dict.fromkeys(names))


def make_blocks(
    configs: Sequence[cfg.AnyStep],
    shop: Workshop,
    held: str = "",
    holder: int = 0,
) -> tuple[Block, ...]:
    """Makes the blocks of a task from a scenario's `tasks`.

    Args:
        configs: The steps, as the scenario has them.
        shop: Properties of the robot and the objects, to check the steps.
        held: Name of the object that the robot carries before the first step;
            empty for none.
        holder: Index of the end effector that carries it.

    Raises:
        FieldError: A step names a link, an object or an end effector that does
            not exist, exceeds the opening of the hand, or puts down an object
            that is not carried.
    """
    blocks = []
    for i, config in enumerate(configs):
        maker = _Maker(config, shop, f"tasks[{i}]", held, holder)
        blocks.append(maker.block())
        held, holder = maker.held, maker.holder
    return tuple(blocks)


class _Maker:
    """Makes the block of one step of a scenario."""

    def __init__(
        self,
        config: cfg.AnyStep,
        shop: Workshop,
        field: str,
        held: str,
        holder: int,
    ):
        self._config, self._shop, self._field = config, shop, field
        self.held, self.holder = held, holder
        names = shop.robot.effectors
        effector = config.effector or names[0]
        if effector not in names:
            problem = unknown_name("end effector", effector, names)
            raise self._error("effector", problem)
        self._effector = names.index(effector)
        self._hand = hand_links(shop.robot, self._effector)

    def block(self) -> Block:
        config = self._config
        kinds = {
            cfg.Pick: self._pick,
            cfg.TakeOver: self._take_over,
            cfg.Place: self._place,
            cfg.ReachTo: self._reach,
            cfg.Approach: self._along,
            cfg.Retreat: self._along,
            cfg.Lift: self._lift,
            cfg.DriveTo: self._drive,
            cfg.Open: self._open,
            cfg.Close: self._close,
            cfg.Attach: self._attach,
            cfg.MoveTo: self._move_to,
            cfg.Release: self._release,
        }
        return kinds[type(config)](config)

    def _error(self, name: str, problem: str) -> FieldError:
        return self._shop.error(joined(self._field, name), problem)

    def _object(self, name: str, field: str = "object") -> str:
        return self._shop.object(name, joined(self._field, field))

    def _step(self, text: str, *rules: ContactRule, **values) -> Step:
        config = self._config
        return Step(
            text=text,
            effector=self._effector,
            position=config.position,
            angle=math.radians(config.angle),
            patience=config.patience,
            rules=(*rules, *self._touches()),
            **values,
        )

    def _touches(self) -> list[ContactRule]:
        links = {*self._shop.robot.tree.names, *self._shop.objects}
        rules = []
        for i, touch in enumerate(self._config.touch):
            field = f"touch[{i}]"
            name = self._object(touch.object, f"{field}.object")
            for link in touch.links:
                if link not in links:
                    problem = unknown_name("link", link, sorted(links))
                    raise self._error(f"{field}.links", problem)
            if name == self.held and touch.stopping is not None:
                problem = "leave it out: the links may touch the carried object"
                raise self._error(f"{field}.stopping", problem)
            named = frozenset(touch.links) or self._hand
            if touch.stopping is None:
                # A carried object must not be pressed into an object that it
                # may touch.
                loads = named & self._shop.overhang.keys()
                rules += [self._contact(name, load) for load in sorted(loads)]
                named -= loads
            if named:
                rules.append(ContactRule(name, named, touch.stopping))
        return rules

    def _held_now(self) -> str:
        if not self.held:
            raise self._shop.error(
                self._field,
                "no object is carried at this step; take one before",
            )
        if self._effector != self.holder:
            names = self._shop.robot.effectors
            mine, theirs = names[self._effector], names[self.holder]
            problem = f"the hand {theirs} holds the {self.held}, not {mine}"
            raise self._error("effector", problem)
        return self.held

    def _take(self, name: str) -> str:
        """Records that this end effector carries an object from now on."""
        is_given = name == self.held and self._effector != self.holder
        if self.held and not is_given:
            problem = f"the {self.held} is still carried; put it down first"
            raise self._error("object", problem)
        self.held, self.holder = self._object(name), self._effector
        return self.held

    def _standing_on(self, support: str, thing: str) -> list[ContactRule]:
        """Lets a carried object overlap slightly with the object below it."""
        if not support:
            return []
        return [self._contact(self._object(support, "support"), thing)]

    def _contact(self, name: str, load: str) -> ContactRule:
        """Lets a carried object touch another object, with a slight overlap."""
        overlap = self._shop.overhang[load] + _ROUNDING
        return ContactRule(name, frozenset({load}), -overlap)

    def _width(self, width: float | None, field: str = "width") -> float:
        where = joined(self._field, field)
        return self._shop.width(width, self._effector, where)

    def _pose(self, pose: PoseConfig, field: str = "") -> np.ndarray:
        where = joined(self._field, field) if field else self._field
        return make_transform(pose, self._shop.where, where).GetAsMatrix4()

    def _reach(self, config: cfg.ReachTo) -> Block:
        name, X = config.object, self._pose(config)
        goal, text = Goal(AT, X), "reaches"
        if name:
            goal = Goal(ON_OBJECT, X, self._object(name))
            text = f"reaches for the {name}"
        return _only(self._step(text, goal=goal))

    def _along(self, config: cfg.Approach) -> Block:
        along = np.array(config.along) / np.linalg.norm(config.along)
        goal = Goal(BY_HAND, _shift(config.distance * along))
        text = "retreats" if isinstance(config, cfg.Retreat) else "approaches"
        return _only(self._step(text, goal=goal, speed=config.speed))

    def _lift(self, config: cfg.Lift) -> Block:
        goal = Goal(BY_WORLD, _shift(config.by))
        text = f"lifts the {self.held}" if self.held else "lifts its hand"
        return _only(self._step(text, goal=goal, speed=config.speed))

    def _drive(self, config: cfg.DriveTo) -> Block:
        if not self._shop.robot.n_base:
            problem = "needs a mobile base, and the robot has none"
            raise self._shop.error(self._field, problem)
        if not self._shop.plans:
            problem = "needs planned paths: set controller.guidance.planning"
            raise self._shop.error(self._field, problem)
        X_WB = planar_pose.matrix(np.array(config.base_pose))
        return _only(self._step("drives", goal=Goal(BASE_TO, X_WB)))

    def _open(self, config: cfg.Open) -> Block:
        width = self._width(config.width)
        return _only(self._step("opens its hand", width=width))

    def _close(self, config: cfg.Close) -> Block:
        width = self._width(config.width)
        return _only(
            self._step("closes its hand", width=width, force=config.force)
        )

    def _attach(self, config: cfg.Attach) -> Block:
        name = self._take(config.object)
        rules = self._standing_on(config.support, name)
        return _only(
            self._step(f"takes the {name}", *rules, action=ATTACH, object=name)
        )

    def _move_to(self, config: cfg.MoveTo) -> Block:
        name = self._held_now()
        goal = Goal(OBJECT_TO, self._pose(config))
        return _only(self._step(f"carries the {name}", goal=goal))

    def _release(self, config: cfg.Release) -> Block:
        name, self.held = self._held_now(), ""
        width = self._width(config.width)
        return _only(
            self._step(
                f"releases the {name}",
                ContactRule(name, self._hand),
                action=RELEASE,
                object=name,
                width=width,
            )
        )

    def _pick(self, config: cfg.Pick) -> Block:
        name = self._take(config.object)
        standing = self._standing_on(config.support, name)
        lift = self._step(
            f"lifts the {name}",
            *standing,
            goal=Goal(BY_WORLD, _shift(config.lift)),
            speed=config.speed,
        )
        ways = self._grasps(config, name, standing, (lift,))
        return Block(f"pick the {name}", ways)

    def _take_over(self, config: cfg.TakeOver) -> Block:
        giver, held = self.holder, self.held
        if not held or held != config.object or giver == self._effector:
            problem = f"no other hand holds the {config.object} at this step"
            raise self._error("object", problem)
        name = self._take(config.object)
        where = joined(self._field, "effector")
        opening = self._step(
            f"lets the {name} go",
            width=self._shop.width(None, giver, where),
        )
        back = _shift([0.0, 0.0, -config.retreat])
        retreat = self._step(
            f"retreats from the {name}",
            goal=Goal(BY_HAND, back),
            speed=config.speed,
        )
        given = [dc.replace(x, effector=giver) for x in (opening, retreat)]
        ways = self._grasps(config, name, [], tuple(given))
        return Block(f"take the {name} over", ways)

    def _grasps(
        self,
        config: cfg.Grasping,
        name: str,
        standing: Sequence[ContactRule],
        then: tuple[Step, ...],
    ) -> tuple[tuple[Step, ...], ...]:
        """The steps that take an object, as one alternative for each grasp."""
        if not config.grasps:
            raise self._error("grasps", "give at least one")
        return tuple(
            (*self._grasp(config, name, standing, i), *then)
            for i in range(len(config.grasps))
        )

    def _grasp(
        self,
        config: cfg.Grasping,
        name: str,
        standing: Sequence[ContactRule],
        i: int,
    ) -> tuple[Step, ...]:
        grasp, field = config.grasps[i], f"grasps[{i}]"
        touching = ContactRule(name, self._hand)
        closed = self._width(grasp.width, f"{field}.width")
        opened = self._width(None, f"{field}.width")
        squeeze = config.squeeze if self._shop.is_stopped else 0.0
        X_OE = self._pose(grasp, field)
        before = X_OE @ _shift([0.0, 0.0, -config.approach])
        line = {"speed": config.speed}
        leave = self._step(
            f"leaves the {name}",
            touching,
            goal=Goal(ON_OBJECT, before, name),
            width=opened,
            **line,
        )
        return (
            self._step(
                f"reaches for the {name}",
                goal=Goal(ON_OBJECT, before, name),
                width=opened,
            ),
            self._step(
                f"approaches the {name}",
                touching,
                goal=Goal(ON_OBJECT, X_OE, name),
                undo=(leave,),
                **line,
            ),
            self._step(
                f"grasps the {name}",
                touching,
                width=max(closed - squeeze, 0.0),
                force=grasp.force or config.force,
                undo=(leave,),
            ),
            self._step(
                f"takes the {name}",
                *standing,
                action=ATTACH,
                object=name,
                grip=closed,
                undo=(leave,),
            ),
        )

    def _place(self, config: cfg.Place) -> Block:
        name = self._held_now()
        ways = [self._put(config, name, X) for X in self._places(config, name)]
        self.held = ""
        return Block(f"place the {name}", tuple(ways))

    def _places(self, config: cfg.Place, name: str) -> list[np.ndarray]:
        """The poses X_WO at which an object is put down, shape (4, 4)."""
        if config.places:
            return [
                self._pose(place, f"places[{i}]")
                for i, place in enumerate(config.places)
            ]
        if not config.support:
            raise self._error("places", "give at least one pose, or a support")
        support = self._object(config.support, "support")
        try:
            found = self._shop.places(
                name, support, config.near, self._effector
            )
        except RemoSplatError as error:
            raise self._error("support", str(error)) from error
        return [X_WO.GetAsMatrix4() for X_WO in found]

    def _put(
        self, config: cfg.Place, name: str, X_WO: np.ndarray
    ) -> tuple[Step, ...]:
        standing = self._standing_on(config.support, name)
        touching = ContactRule(name, self._hand)
        over = _shift([0.0, 0.0, config.lower]) @ X_WO
        line = {"speed": config.speed}
        back = self._step(
            f"lifts the {name} again",
            *standing,
            goal=Goal(OBJECT_TO, over),
            **line,
        )
        opened = self._width(None)
        return (
            self._step(f"carries the {name}", goal=Goal(OBJECT_TO, over)),
            self._step(
                f"puts the {name} down",
                *standing,
                goal=Goal(OBJECT_TO, X_WO),
                undo=(back,),
                **line,
            ),
            self._step(
                f"releases the {name}",
                touching,
                action=RELEASE,
                object=name,
                width=opened,
            ),
            self._step(
                "retreats",
                touching,
                goal=Goal(BY_HAND, _shift([0.0, 0.0, -config.retreat])),
                **line,
            ),
        )


def _only(step: Step) -> Block:
    return Block(step.text, ((step,),))


def _shift(p: np.ndarray | Sequence[float]) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = p
    return X
