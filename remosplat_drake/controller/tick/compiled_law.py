"""`CompiledLaw`: a law's ingredients, packed for the kernels of a tick."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.ingredients import SelfCollisionDamper
from remosplat_drake.controller.ingredients.kernels.assemble import (
    PARTS,
    Assembled,
    Parts,
)
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
from remosplat_drake.controller.program.kernels.tick_arrays import NearSettings
from remosplat_drake.controller.program.term import NameTakenError
from remosplat_drake.controller.tick.compiled_outside import CompiledOutside
from remosplat_drake.robot.robot_model import RobotModel


class CompiledLaw:
    """The ingredients of a law, packed for kernels.

    One kernel adds the terms of the library's ingredients, and calls the
    functions of a user's compiled ingredients. Then ingredients in Python add
    their terms. Settings are read only once, when the law is made.

    Attributes:
        outside: The ingredients in Python.
        names: Names of the terms of the compiled ingredients.
    """

    def __init__(self, robot: RobotModel, ingredients: Sequence[AnyIngredient]):
        """Packs all ingredients of a law.

        Args:
            robot: The robot that is driven.
            ingredients: The ingredients.

        Raises:
            NameTakenError: Two ingredients are of the same class of the
                library, or the name of a user's compiled ingredient is not
                unique.
            RemoSplatError: A compiled ingredient cannot be compiled.
        """
        self._made_of = robot, tuple(ingredients)
        own: dict[type, CompiledIngredient] = {}
        outside, functions = [], []
        for part in ingredients:
            if not _is_compiled(part):
                outside.append(cast(Ingredient, part))
                continue
            kind = next((k for k in PARTS if isinstance(part, k)), None)
            if kind is None or hasattr(part, "add"):
                functions.append(cast(CompiledIngredient, part))
                continue
            if kind in own:
                raise NameTakenError(
                    f"two ingredients are of the class {kind.__name__}: their"
                    f" terms would have the same name, {kind.term!r}"
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
        self._functions = CompiledOutside(robot, functions)
        self.names = _names([*own.values(), *functions])
        added_by = self._functions.added_by
        self._arrays = Packed(Parts(tuple(settings), present, added_by))
        near = self._own.near_settings
        if not present[_OWN]:
            near = near._replace(reach=-1.0)
        self._near = Packed(near)

    def __reduce__(self):
        # In another process, the functions have other addresses.
        return CompiledLaw, self._made_of

    @property
    def ingredients(self) -> Sequence[CompiledIngredient]:
        """The compiled ingredients; those of the library come first."""
        return *self._parts, *self._functions.ingredients

    @property
    def parts(self) -> Packed[Parts]:
        """The compiled ingredients, packed for kernels."""
        return self._arrays

    @property
    def near(self) -> Packed[NearSettings]:
        """Argument of `near_arrays`: the pairs and the largest distance.

        The distance is negative if the law has no `SelfCollisionDamper`.
        """
        return self._near

    def check(self, found: Assembled) -> None:
        """Checks that all terms are valid; see `CompiledOutside.check`.

        Args:
            found: The program that kernels have assembled.
        """
        self._functions.check(found)


_OWN = PARTS.index(SelfCollisionDamper)


def _is_compiled(part: AnyIngredient) -> bool:
    is_python = hasattr(part, "AddToProgram")
    return isinstance(part, CompiledIngredient) and not is_python


def _names(ingredients: Sequence[CompiledIngredient]) -> frozenset[str]:
    """Returns the names of ingredients' terms."""
    names: set[str] = set()
    for part in ingredients:
        if part.term in names:
            raise NameTakenError(
                f"two compiled ingredients have the name {part.term!r}"
            )
        names.add(part.term)
    return frozenset(names)


def _floats(settings: Any) -> Any:
    """Converts numbers to floats; integers would compile kernels again."""
    return settings._make(float(x) if type(x) is int else x for x in settings)
