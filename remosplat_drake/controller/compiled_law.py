"""`CompiledLaw`: a law's ingredients, of which one kernel adds the most."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from remosplat_drake.base.packed import Packed
from remosplat_drake.controller.compiled_program import CompiledProgram
from remosplat_drake.controller.controller_config import default_ingredients
from remosplat_drake.controller.ingredient import AnyIngredient, Ingredient
from remosplat_drake.controller.ingredients import SelfCollisionDamper
from remosplat_drake.controller.joined_program import JoinedProgram
from remosplat_drake.controller.kernels.assemble import (
    PARTS,
    Parts,
    assemble_tick,
)
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.tick_arrays import (
    NearQuestion,
    ProgramArrays,
)
from remosplat_drake.controller.law_program import LawProgram
from remosplat_drake.controller.term import NameTakenError
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import STILL


class CompiledLaw:
    """The ingredients of a law, as programs are built of them.

    One kernel adds the library's own; what is from outside adds itself
    afterwards. Settings are read when the law is made.

    Attributes:
        outside: The ingredients from outside, which no kernel adds.
    """

    def __init__(self, robot: RobotModel, ingredients: Sequence[AnyIngredient]):
        """Makes it of all ingredients of a law.

        Args:
            robot: The robot that is driven.
            ingredients: The ingredients.

        Raises:
            NameTakenError: Two ingredients are of one kind of the library's.
        """
        self._robot = robot
        own: dict[type, CompiledIngredient] = {}
        outside = []
        for part in ingredients:
            kind = _kind(part)
            if kind is None:
                outside.append(cast(Ingredient, part))
                continue
            if kind in own:
                raise NameTakenError(
                    f"two ingredients are a {kind.__name__}: their terms would"
                    f" have one name, {kind.term!r}"
                )
            own[kind] = cast(CompiledIngredient, part)
        self.outside: Sequence[Ingredient] = tuple(outside)
        present = np.array([kind in own for kind in PARTS])
        others = {type(part): part for part in default_ingredients(robot)}
        self._parts = [
            own.get(kind) or cast(CompiledIngredient, others[kind])
            for kind in PARTS
        ]
        self._own = cast(SelfCollisionDamper, self._parts[_OWN])
        settings = [_floats(part.settings(robot)) for part in self._parts]
        self._arrays = Packed(Parts._make([*settings, present]))
        near = self._own.near_question
        if not present[_OWN]:
            near = near._replace(reach=-1.0)
        self._near = Packed(near)

    @property
    def ingredients(self) -> Sequence[CompiledIngredient]:
        """An ingredient of each kind that kernels add, in their order."""
        return self._parts

    @property
    def parts(self) -> Packed[Parts]:
        """The library's ingredients, as kernels take them."""
        return self._arrays

    @property
    def near(self) -> Packed[NearQuestion]:
        """What `near_arrays` takes: the pairs and how far it looks.

        It does not where there is no `SelfCollisionDamper`.
        """
        return self._near

    def program(self, tick: Tick) -> LawProgram:
        """Builds the program of a tick as it stands.

        Args:
            tick: What is known at the tick.

        Raises:
            TermError: A term cannot be used; the text names it and its
                ingredient.
            NameTakenError: Two terms of a kind have one name.
            IngredientError: An ingredient raises.
        """
        compiled = CompiledProgram(self._assemble(tick), self._parts, tick)
        if not self.outside:
            return compiled
        return JoinedProgram(compiled, self.outside, tick)

    def _assemble(self, tick: Tick) -> ProgramArrays:
        # Copies, since numba compiles for arrays that may be written.
        clearances = tick.clearances
        rows = (
            clearances.sphere.copy(),
            clearances.distance.copy(),
            clearances.direction_W.copy(),
        )
        tube = tick.sphere_tube
        if tube is None:
            tube = np.zeros(len(self._robot.spheres))
        movers = STILL if tick.movers is None else tick.movers
        return assemble_tick(
            self._arrays,
            self._near,
            self._robot.arrays,
            movers.arrays,
            movers.age(tick.time),
            tick.aim.arrays,
            rows,
            np.array(tick.state.q, float),
            np.array(tick.u_previous, float),
            float(tick.dt),
            tube,
            tick.guidance.arrays,
        )


_OWN = PARTS.index(SelfCollisionDamper)


def _kind(part: AnyIngredient) -> type[CompiledIngredient] | None:
    """Returns which of the library's kinds it is; None if from outside."""
    if hasattr(part, "AddToProgram"):
        return None
    return next((kind for kind in PARTS if isinstance(part, kind)), None)


def _floats(settings: Any) -> Any:
    """Makes numbers floats: kernels are compiled anew for whole numbers."""
    return settings._make(float(x) if type(x) is int else x for x in settings)
