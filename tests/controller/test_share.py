"""The greatest share of their retreats that rows can have at once."""

import hypothesis as hyp
import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.optimize import linprog

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.program.kernels.dense import prune
from remosplat_drake.controller.program.kernels.tick_arrays import make_program
from remosplat_drake.controller.tick.kernels.share import ease, greatest_share

BOUND = np.array([0.2, 1.0])


@kernel
def share_of(A, b, yields, bound):
    """The share, and what its rows demand when they are eased."""
    program = make_program(bound, 0, 1, len(b))
    program.count[0] = len(b)
    for i in range(len(b)):
        program.A[i], program.b[i], program.raised[i] = A[i], b[i], yields[i]
    prune(program)
    share = greatest_share(program)
    if share >= 0.0:
        ease(program, share)
    return share, program.b[: len(b)].copy()


def share(rows, yields, bound=BOUND):
    """Of rows (a_0, a_1, b)."""
    given = np.array(rows, float)
    A, b = given[:, :-1].copy(), given[:, -1].copy()
    return share_of(A, b, np.array(yields), bound)


def test_bounds_allow_half_of_a_retreat():
    found, b = share([[1, 0, -0.4]], [True])
    assert found == pytest.approx(0.5, abs=1e-5)
    assert b == pytest.approx([-0.18], abs=1e-5)


def test_two_that_are_parted_by_one_motion_share_it():
    # u_0 + u_1 <= -0.6 s and u_0 - u_1 <= -0.2 s with u_0 >= -0.2: the sum of
    # both says 2 u_0 <= -0.8 s.
    found, b = share([[1, 1, -0.6], [1, -1, -0.2]], [True, True])
    assert found == pytest.approx(0.5, abs=1e-5)
    assert b == pytest.approx([-0.27, -0.09], abs=1e-5)


def test_what_can_be_had_as_a_whole_is_had():
    found, _ = share([[0, 1, -0.4], [1, 0, 0.1]], [True, False])
    assert found == pytest.approx(1.0, abs=1e-5)


def test_what_contradicts_itself_is_not_parted_and_comes_no_nearer():
    found, b = share([[1, 0, -0.1], [-1, 0, -0.1]], [True, True])
    assert found == pytest.approx(0.0, abs=1e-9)
    assert b == pytest.approx([0.0, 0.0], abs=1e-9)


def test_what_does_not_yield_may_leave_nothing():
    found, _ = share([[1, 0, -0.1], [-1, 0, -0.1]], [True, False])
    assert found == -1.0


def share_by_linear_program(A, b, yields, bound) -> float:
    n = len(bound)
    found = linprog(
        -np.eye(n + 1)[n],
        A_ub=np.column_stack([A, np.where(yields, -b, 0.0)]),
        b_ub=np.where(yields, 0.0, b),
        bounds=[*zip(-bound, bound, strict=True), (0.0, 1.0)],
    )
    assert found.status == 0, "u = 0 keeps all of them"
    return float(found.x[n])


ENTRIES = st.floats(-1, 1).map(lambda x: round(x, 2))


@hyp.given(
    A=hnp.arrays(float, (5, 3), elements=ENTRIES),
    b=hnp.arrays(float, 5, elements=ENTRIES),
)
def test_it_is_that_of_a_linear_program(A, b):
    yields, bound = b < 0, np.array([0.1, 0.5, 1.0])
    found, eased = share_of(A, b, yields, bound)
    wanted = share_by_linear_program(A, b, yields, bound)
    # The price of the command costs a little of the share.
    assert found == pytest.approx(wanted, abs=1e-4)
    np.testing.assert_allclose(eased[yields], 0.9 * found * b[yields])
    np.testing.assert_array_equal(eased[~yields], b[~yields])
