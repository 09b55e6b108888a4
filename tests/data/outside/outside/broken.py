"""Ingredients with defects."""

import dataclasses as dc

import numpy as np

import remosplat_drake as rs


@dc.dataclass
class NotANumber(rs.Config):
    """A cost that is not a number."""

    def AddToProgram(self, program: rs.ReactiveProgram, tick: rs.Tick) -> None:
        program.add_linear_cost("nan", np.full(program.n_u, np.nan))


@dc.dataclass
class Raises(rs.Config):
    """A cost with a defect."""

    def AddToProgram(self, program: rs.ReactiveProgram, tick: rs.Tick) -> None:
        program.add_linear_cost("none", program.upper * (1 // 0))
