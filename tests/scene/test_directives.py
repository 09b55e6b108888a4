"""Objects that Drake's model directives name, as primitives of a scene."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.common.schema import Rotation, Transform
from pydrake.multibody.parsing import (
    AddDirectives,
    AddFrame,
    AddModel,
    AddWeld,
    ModelDirective,
)

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import PACKAGE_SCHEME
from remosplat_drake.scene.directives import read_directives

BOX = "<box><size>0.2 0.4 0.6</size></box>"
CYLINDER = "<cylinder><radius>0.1</radius><length>0.5</length></cylinder>"
SPHERE = "<sphere><radius>0.1</radius></sphere>"
MESH = "<mesh><uri>file:///nowhere.obj</uri></mesh>"


def sdf(folder: Path, *shapes: str, kind: str = "collision") -> ModelDirective:
    """A directive for a model of one body, 1 m above the other each shape."""
    parts = (
        f"<{kind} name='part{i}'><pose>0 0 {i} 0 0 0</pose>"
        f"<geometry>{shape}</geometry></{kind}>"
        for i, shape in enumerate(shapes)
    )
    (folder / "thing.sdf").write_text(
        "<sdf version='1.7'><model name='any'><link name='body'>"
        f"{''.join(parts)}</link></model></sdf>"
    )
    return ModelDirective(add_model=AddModel(name="thing", file="thing.sdf"))


def weld(child: str = "thing::body", parent: str = "world") -> ModelDirective:
    """Fixes a body half a metre along x, turned to the left."""
    X_PC = Transform()
    X_PC.translation = [0.5, 0, 0]
    X_PC.rotation = Rotation.Rpy(deg=[0, 0, 90])
    return ModelDirective(
        add_weld=AddWeld(parent=parent, child=child, X_PC=X_PC)
    )


def test_a_welded_model_becomes_primitives_in_the_world(tmp_path):
    scene = read_directives([sdf(tmp_path, BOX, CYLINDER), weld()], tmp_path)
    (box,), (cylinder,) = scene.boxes, scene.cylinders
    np.testing.assert_allclose(box.half_extents, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(box.X_WP.translation(), [0.5, 0, 0], atol=1e-15)
    np.testing.assert_allclose(
        box.X_WP.rotation().matrix() @ [1, 0, 0], [0, 1, 0], atol=1e-15
    )
    np.testing.assert_allclose(
        cylinder.X_WP.translation(), [0.5, 0, 1], atol=1e-15
    )
    assert (cylinder.radius, cylinder.half_height) == (0.1, 0.25)


def test_no_directives_are_an_empty_scene(tmp_path):
    assert len(read_directives([], tmp_path)) == 0


def test_directives_of_a_file_and_frames_count_too(tmp_path):
    sdf(tmp_path, BOX)
    (tmp_path / "all.dmd.yaml").write_text(
        "directives:\n"
        f"- add_model: {{name: thing, file: 'file://{tmp_path}/thing.sdf'}}\n"
    )
    X_WF = Transform()
    X_WF.base_frame = "world"
    X_WF.translation = [0, 0, 2]
    directives = [
        ModelDirective(add_directives=AddDirectives(file="all.dmd.yaml")),
        ModelDirective(add_frame=AddFrame(name="shelf", X_PF=X_WF)),
        weld(parent="shelf"),
    ]
    (box,) = read_directives(directives, tmp_path).boxes
    np.testing.assert_allclose(box.X_WP.translation(), [0.5, 0, 2], atol=1e-15)


@pytest.mark.parametrize(
    ("shapes", "kind", "directives", "problem"),
    [
        (
            [SPHERE],
            "collision",
            [weld()],
            "model 'thing::body': shape 'thing::part0' is a Sphere: only boxes",
        ),
        ([MESH], "collision", [weld()], "nowhere.obj"),
        ([BOX], "visual", [weld()], "'thing::body': has only a visual shape"),
        ([BOX], "collision", [], "'thing::body': is not welded to the world"),
        ([BOX], "collision", [weld("other::body")], "other"),
        ([BOX], "collision", [weld("world", "thing::body")], "weld"),
        (["<ball/>"], "collision", [weld()], "ball"),
    ],
)
def test_what_cannot_be_part_of_a_scene_is_refused_in_one_line(
    tmp_path, shapes, kind, directives, problem
):
    thing = sdf(tmp_path, *shapes, kind=kind)
    with pytest.raises(RemoSplatError) as caught:
        read_directives([thing, *directives], tmp_path)
    assert problem.casefold() in str(caught.value).casefold()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("file", "problem"),
    [
        ("nowhere.sdf", "nowhere.sdf: no such file"),
        (f"{PACKAGE_SCHEME}nowhere.sdf", "nowhere.sdf"),
        ("package://unheard_of/box.sdf", "unheard_of"),
    ],
)
def test_a_file_that_is_not_there_is_named(tmp_path, file, problem):
    directive = ModelDirective(add_model=AddModel(name="a", file=file))
    with pytest.raises(RemoSplatError, match=problem):
        read_directives([directive], tmp_path)
