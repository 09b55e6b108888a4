"""`CompiledLaw`: a law's ingredients, of which one kernel adds the most."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np

from remosplat_drake.base.packed import Packed
from remosplat_drake.controller.ingredients import SelfCollisionDamper
from remosplat_drake.controller.ingredients.kernels.assemble import PARTS, Parts
from remosplat_drake.controller.ingredients.make_ingredients import (
    make_ingredients,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.ingredient import (
    AnyIngredient,
    Ingredient,
)
from remosplat_drake.controller.program.kernels.tick_arrays import NearQuestion
from remosplat_drake.controller.program.term import NameTakenError
from remosplat_drake.robot.robot_model import RobotModel


class CompiledLaw:
    """The ingredients of a law, as kernels take them.

    One kernel adds the library's own; those from outside add their terms by
    Python afterwards. Settings are read when the law is made.

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
        others = {type(part): part for part in make_ingredients(robot)}
        self._parts = [
            own.get(kind) or cast(CompiledIngredient, others[kind])
            for kind in PARTS
        ]
        self._own = cast(SelfCollisionDamper, self._parts[_OWN])
        settings = [_floats(part.settings(robot)) for part in self._parts]
        self._arrays = Packed(Parts(tuple(settings), present))
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

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of the terms of the library's ingredients that are there."""
        present = self._arrays.present.tolist()
        return frozenset(
            part.term
            for part, is_there in zip(self._parts, present, strict=True)
            if is_there
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
