"""The frames of a long capture that are used."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.capture.keyframes import (
    VOXEL,
    choose_keyframes,
    looks_of_view,
    sharpness,
)


def looks(*voxels: int, direction: int = 0) -> np.ndarray:
    """Looks at voxels that are far from each other, from one direction."""
    return np.array(sorted({32 * 10 * v + direction for v in voxels}), np.int64)


def chosen(frames: list[np.ndarray], most: int, sharp=None) -> list[int]:
    sharp = np.ones(len(frames)) if sharp is None else np.array(sharp)
    return choose_keyframes(frames, sharp, most).chosen.tolist()


def test_what_shows_most_comes_first_by_hand():
    """Then what adds most to it: 3 voxels once more add less than 2 new."""
    frames = [looks(1, 2), looks(1, 2, 3), looks(1, 2, 3), looks(7, 8)]
    assert chosen(frames, 1) == [1]
    assert chosen(frames, 2) == [1, 3]
    assert chosen(frames, 3) == [1, 2, 3]
    assert chosen(frames, 4) == [0, 1, 2, 3]


def test_another_direction_is_better_than_the_same():
    again, other = looks(1, 2), looks(1, 2, direction=7)
    assert chosen([looks(1, 2), again, other], 2) == [0, 2]


def test_of_equal_frames_the_sharp_one():
    frames = [looks(1, 2)] * 3
    assert chosen(frames, 1, [0.2, 0.9, 0.5]) == [1]
    assert chosen(frames, 1, [0.5, 0.5, 0.5]) == [0]


def test_no_surface_is_left_out_for_a_blur():
    """Two sharp images of one place, and a blurred one of another."""
    frames = [looks(1, 2), looks(1, 2), looks(7, 8)]
    assert chosen([*frames[:2], looks(*range(7, 30))], 2, [1, 1, 0]) == [0, 2]


def test_tells_what_the_others_have_seen():
    """Of five voxels, one is missed; its neighbour would not count."""
    frames = [looks(1, 2, 3, 4), looks(9)]
    result = choose_keyframes(frames, np.ones(2), 1)
    assert result.missed == 1 / 5
    assert "1 of 2 frames are used" in result.words
    assert (
        "20.0 % of the captured surfaces are only in the remaining frames"
        in result.words
    )
    beside = [looks(1, 2, 3, 4), looks(1, 2, 3) + (1 << 5)]
    assert choose_keyframes(beside, np.ones(2), 1).missed == 0


def test_frames_without_depth_are_not_chosen():
    nothing = looks()
    assert chosen([nothing, looks(1), nothing], 2) == [1]
    assert chosen([nothing] * 3, 2) == [0, 1]


def test_the_looks_of_a_wall_by_hand():
    """A wall 1.05 m ahead of a camera at W's origin, and the same from behind.

    From W's origin it is two pixels of one voxel; behind the wall the camera
    looks back.
    """
    K = np.array([[1e3, 0, 0.0], [0, 1e3, 0.0], [0, 0, 1]])
    depth = np.full((1, 2), 1.05, np.float32)
    X_WC = np.eye(4)
    X_WC[:3, 3] = [0.05, 0.05, 0]
    (ahead,) = {look & 31 for look in looks_of_view(K, depth, X_WC).tolist()}
    assert ahead >> 3 == 2 and ahead & 4
    turned = X_WC @ np.diag([1.0, -1, -1, 1])
    turned[2, 3] = 2.1
    voxel = {look >> 5 for look in looks_of_view(K, depth, X_WC).tolist()}
    again = looks_of_view(K, depth, turned)
    assert {look >> 5 for look in again.tolist()} == voxel
    assert len(voxel) == 1
    (back,) = {look & 31 for look in again.tolist()}
    assert back >> 3 == 2 and not back & 4
    assert not len(looks_of_view(K, np.zeros((1, 2)), X_WC))


def test_neighbouring_voxels_are_one_apart():
    K = np.array([[1.0, 0, 0.5], [0, 1.0, 0.5], [0, 0, 1]])
    depth = np.ones((1, 1), np.float32)
    for axis in range(3):
        numbers = []
        for step in (0, 1):
            X_WC = np.eye(4)
            X_WC[:3, 3] = -3.05
            X_WC[axis, 3] += step * VOXEL
            numbers.append(int(looks_of_view(K, depth, X_WC)[0]) >> 5)
        assert numbers[1] - numbers[0] == 1 << 19 * axis


def test_sharpness_by_hand():
    """At 60 pixels of focal length 1 rad/s blurs by a pixel in 1/60 s."""
    assert sharpness(np.zeros(6), 60.0, 2.0) == 1
    assert sharpness(np.full(6, np.nan), 60.0, 2.0) == 1
    turning = np.array([0, 0.6, 0.8, 0, 0, 0])
    assert sharpness(turning, 60.0, 2.0) == pytest.approx(1 / 2)
    moving = np.array([0, 0, 0, 0, 0, 4.0])
    assert sharpness(moving, 60.0, 2.0) == pytest.approx(1 / 5)


@st.composite
def toy_captures(draw) -> list[np.ndarray]:
    kinds = st.sets(st.integers(0, 40), max_size=8)
    return [
        np.array(sorted(draw(kinds)), np.int64)
        for _ in range(draw(st.integers(1, 7)))
    ]


def worth(frames: list[np.ndarray], picked: tuple[int, ...]) -> float:
    """What a choice of sharp frames is worth, as the module says."""
    views, seen = {}, set()
    for i in picked:
        seen |= set(frames[i].tolist())
        for voxel in {look >> 5 for look in frames[i].tolist()}:
            views[voxel] = views.get(voxel, 0) + 1
    halves = sum(2 - 2.0 ** (1 - count) for count in views.values())
    return halves + 0.5 * len(seen)


@given(toy_captures(), st.integers(1, 7))
def test_nearly_as_good_as_the_best_of_all_choices(frames, most):
    """The greedy choice is worth at least 1 - 1/e of the best one."""
    picked = tuple(chosen(frames, most))
    assert len(set(picked)) == len(picked) <= most
    best = max(
        worth(frames, choice)
        for k in range(most + 1)
        for choice in itertools.combinations(range(len(frames)), k)
    )
    assert worth(frames, picked) >= (1 - np.exp(-1)) * best - 1e-9


@given(toy_captures(), st.integers(1, 7))
def test_as_one_that_compares_all_frames_each_time(frames, most):
    picked: list[int] = []
    while len(picked) < most:
        rest = [i for i in range(len(frames)) if i not in picked]
        gains = [
            worth(frames, (*picked, i)) - worth(frames, tuple(picked))
            for i in rest
        ]
        if not gains or max(gains) <= 0:
            break
        picked.append(rest[int(np.argmax(gains))])
    if picked:
        assert chosen(frames, most) == sorted(picked)
