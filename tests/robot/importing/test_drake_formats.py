"""SDFormat, MJCF and model directives move and weigh as Drake has them."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.importing.arm_choice import choose_arm
from remosplat_drake.robot.importing.completion import complete_limits
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.urdf import Urdf


def read(path: Path) -> tuple[Urdf, Findings]:
    findings = Findings()
    urdf, _ = read_robot(path, Packages(path, {}, {}), {}, findings)
    return urdf, findings


def only_tool(urdf: Urdf, findings: Findings) -> str:
    (link,) = choose_arm(urdf, Srdf(), {}, findings).end_effectors.values()
    return link


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def finalized(model: Path | str, base: str) -> MultibodyPlant:
    """The plant of a file or of the text of a URDF, its base at the origin."""
    plant = MultibodyPlant(time_step=0.0)
    if isinstance(model, Path):
        Parser(plant).AddModels(str(model))
    else:
        Parser(plant).AddModelsFromString(model, "urdf")
    if base != "world":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(base))
    plant.Finalize()
    return plant


def assert_same_robot(path: Path, urdf: Urdf, frames: list[str]):
    """Drake reads the file and the URDF made of it as the same mechanism."""
    text = ElementTree.tostring(urdf.root, encoding="unicode")
    plants = [finalized(path, urdf.base), finalized(text, urdf.base)]
    joints = [joint.name for joint in urdf.joints.values() if joint.moves]
    contexts = [plant.CreateDefaultContext() for plant in plants]
    rng = np.random.default_rng(0)
    for q in rng.uniform(-0.4, 0.4, (5, len(joints))):
        poses = []
        for plant, context in zip(plants, contexts, strict=True):
            for name, position in zip(joints, q, strict=True):
                joint = plant.GetJointByName(name)
                positions = plant.GetPositions(context)
                positions[joint.position_start()] = position
                plant.SetPositions(context, positions)
            poses.append(
                [
                    plant.GetFrameByName(name)
                    .CalcPoseInWorld(context)
                    .GetAsMatrix4()
                    for name in frames
                ]
            )
        np.testing.assert_allclose(poses[0], poses[1], atol=1e-12)
        # What it weighs, and where, is in the matrix of all its masses.
        masses = [
            np.linalg.eigvalsh(plant.CalcMassMatrix(context))
            for plant, context in zip(plants, contexts, strict=True)
        ]
        np.testing.assert_allclose(masses[0], masses[1], rtol=1e-9)


INERTIA = """<inertial><pose>0.1 0.02 0.03 0.4 0.5 0.6</pose><mass>2</mass>
  <inertia><ixx>0.03</ixx><iyy>0.04</iyy><izz>0.05</izz><ixy>0.001</ixy>
  <ixz>-0.002</ixz><iyz>0.003</iyz></inertia></inertial>"""

SDF = f"""<sdf version="1.9" xmlns:drake="http://drake.mit.edu">
<model name="crane">
  <link name="foot"><pose>0.3 0 0 0 0 1</pose>{INERTIA}
    <collision name="c"><geometry>
      <box><size>0.2 0.2 0.1</size></box></geometry></collision></link>
  <link name="boom"><pose relative_to="foot">0.1 0.2 0.3 0.4 0.5 0.6</pose>
    {INERTIA}
    <visual name="v"><pose>0 0 0.1 0 0 0</pose>
      <geometry><capsule><radius>0.02</radius><length>0.3</length></capsule>
      </geometry>
      <material><diffuse>1 0.5 0 1</diffuse></material></visual></link>
  <link name="rod"><pose relative_to="swing">0 0 0.2 0 0 0</pose>{INERTIA}
  </link>
  <link name="hook"><pose relative_to="rod">0.1 0 0 0 0 0</pose>{INERTIA}
  </link>
  <frame name="tool" attached_to="hook"><pose>0 0 0.1 0 1.5 0</pose></frame>
  <joint name="swing" type="revolute">
    <pose relative_to="boom">0.05 -0.1 0.15 0.1 0.2 0.3</pose>
    <parent>foot</parent><child>boom</child>
    <axis><xyz>0 0.6 0.8</xyz>
      <limit><lower>-1</lower><upper>2</upper><velocity>3</velocity></limit>
    </axis></joint>
  <joint name="reach" type="prismatic"><pose>0.01 0.02 0.03 1 2 3</pose>
    <parent>boom</parent><child>rod</child>
    <axis><xyz expressed_in="foot">0 0 1</xyz>
      <limit><lower>-0.5</lower><upper>0.5</upper></limit></axis></joint>
  <joint name="turn" type="continuous"><parent>rod</parent><child>hook</child>
    <axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"""


def test_sdformat_with_poses_relative_to_everything(tmp_path):
    path = written(tmp_path / "crane.sdf", SDF)
    urdf, findings = read(path)
    assert (urdf.name, urdf.base) == ("crane", "foot")
    assert dict(findings.found)["format"].startswith("SDFormat")
    frames = ["foot", "boom", "rod", "hook", "tool"]
    assert_same_robot(path, urdf, frames)
    swing, reach, turn = (urdf.joints[x] for x in ("swing", "reach", "turn"))
    assert (swing.lower, swing.upper, swing.velocity) == (-1, 2, 3)
    assert (reach.lower, reach.upper) == (-0.5, 0.5)
    assert np.isnan(reach.velocity)
    assert turn.kind == "continuous"
    assert only_tool(urdf, findings) == "tool"
    (visual,) = urdf.links["boom"].findall("visual")
    assert visual.find("material/color").get("rgba") == "1 0.5 0 1"
    (capsule,) = visual.find("geometry")
    assert capsule.tag == "{http://drake.mit.edu}capsule"
    assert float(capsule.get("length")) == 0.3


def test_sdformat_includes_models_by_their_folders(tmp_path):
    written(tmp_path / "models/crane/model.sdf", SDF)
    written(
        tmp_path / "models/crane/model.config",
        "<model><sdf version='1.4'>old.sdf</sdf>"
        "<sdf version='1.9'>model.sdf</sdf></model>",
    )
    path = written(
        tmp_path / "models/cell/cell.sdf",
        '<sdf version="1.9"><model name="cell"><link name="table"/>'
        "<include><uri>model://crane</uri><name>first</name></include>"
        "<include><uri>model://crane</uri><name>second</name></include>"
        '<joint name="bolts" type="fixed"><parent>table</parent>'
        "<child>first::foot</child></joint>"
        '<joint name="chain" type="fixed"><parent>first::hook</parent>'
        "<child>second::foot</child></joint></model></sdf>",
    )
    urdf, findings = read(path)
    assert (urdf.name, urdf.base) == ("cell", "table")
    # What is there twice begins with the name of its model.
    chain = [joint.name for joint in urdf.chain("cell_second_hook")]
    assert [name for name in chain if name.endswith("_swing")] == [
        "cell_first_swing",
        "cell_second_swing",
    ]
    arm = choose_arm(urdf, Srdf(), {}, findings)
    assert arm.end_effectors[""] == "cell_second_tool"
    assert len(arm.joints) == 6


MJCF = """<mujoco model="arm">
  <compiler angle="degree" autolimits="true" eulerseq="XYZ"/>
  <include file="parts/defaults.xml"/>
  <worldbody>
    <light pos="0 0 2"/>
    <geom type="plane" size="1 1 0.1"/>
    <body name="base" pos="0.1 0 0.2" euler="0 0 30">
      <geom type="box" size="0.1 0.1 0.05"/>
      <body name="upper" pos="0 0 0.1">
        <joint name="pan" axis="0 0 1" range="-90 90" pos="0.02 0.03 0"/>
        <joint name="tilt" axis="0 1 0"/>
        <geom class="beam" fromto="0 0 0 0.3 0 0"/>
        <body name="lower" pos="0.3 0 0" quat="0.9 0.1 0.2 0.3">
          <joint name="slide" type="slide" axis="1 0 0" range="-0.1 0.2"/>
          <geom type="ellipsoid" size="0.1 0.05 0.04" rgba="1 0 0 1"/>
          <site name="ee_site" pos="0 0 0.1" euler="90 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="pan" kp="100"/></actuator>
</mujoco>"""

DEFAULTS = """<mujocoinclude><default>
  <joint range="-60 45"/>
  <default class="beam"><geom type="capsule" size="0.03"/></default>
</default></mujocoinclude>"""


def mjcf(folder: Path, text: str = MJCF) -> Path:
    written(folder / "parts" / "defaults.xml", DEFAULTS)
    return written(folder / "arm.xml", text)


def test_mjcf_with_defaults_includes_and_sites(tmp_path):
    path = mjcf(tmp_path)
    urdf, findings = read(path)
    assert urdf.base == "world"
    pan, tilt, slide = (urdf.joints[x] for x in ("pan", "tilt", "slide"))
    assert pan.upper == pytest.approx(np.pi / 2)
    assert tilt.lower == pytest.approx(-np.pi / 3)
    assert (slide.kind, slide.lower, slide.upper) == ("prismatic", -0.1, 0.2)
    assert only_tool(urdf, findings) == "ee_site"
    guessed = dict(findings.guessed)
    assert "<light>" in guessed["ignored by Drake"]
    assert "shapes of the world" in guessed["left out"]
    # Drake reads neither the include nor the site, and puts the first of two
    # joints of a body elsewhere.
    plain = MJCF.replace(
        '<include file="parts/defaults.xml"/>', DEFAULTS[15:-16]
    )
    plain = plain.replace("<site", "<body")
    plain = plain.replace(
        '<joint name="tilt"', '<body name="u"><joint name="tilt"'
    )
    plain = plain.replace('name="upper"', 'name="outer"')
    plain = plain.replace('name="u"', 'name="upper"')
    end = plain.rindex("</body>")
    plain = f"{plain[:end]}</body>{plain[end:]}"
    same = written(tmp_path / "plain.xml", plain)
    assert_same_robot(same, urdf, ["base", "upper", "lower", "ee_site"])


def test_several_joints_of_a_body_turn_where_the_body_is(tmp_path):
    path = mjcf(
        tmp_path,
        '<mujoco><compiler angle="radian"/><worldbody><body name="a"'
        ' pos="1 0 0" euler="0 0 1.5707963267948966">'
        '<joint name="turn" axis="0 0 1" pos="0.1 0 0"/>'
        '<joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1"/>'
        "</body></worldbody></mujoco>",
    )
    urdf, _ = read(path)
    text = ElementTree.tostring(urdf.root, encoding="unicode")
    plant = finalized(text, "world")
    context = plant.CreateDefaultContext()
    plant.GetJointByName("turn").set_angle(context, np.pi / 2)
    plant.GetJointByName("slide").set_translation(context, 0.2)
    X_WA = plant.GetFrameByName("a").CalcPoseInWorld(context)
    # The body's x axis is the world's y axis. It turns about (1, 0.1, 0) until
    # it points backwards from there: its origin comes to (1.1, 0.1, 0), and
    # then slides backwards.
    np.testing.assert_allclose(X_WA.translation(), [0.9, 0.1, 0], atol=1e-12)
    np.testing.assert_allclose(
        X_WA.rotation().matrix(), np.diag([-1, -1, 1]), atol=1e-12
    )


EXCLUDED = '<contact><exclude body1="base" body2="lower"/></contact>'
HOME = '<keyframe><key name="home" qpos="0.1 0.2 0.05"/></keyframe>'


def test_the_only_body_that_floats_is_fixed(tmp_path):
    text = (
        "<mujoco><worldbody><body name='pelvis' pos='0 0 1'><freejoint/>"
        "<geom size='0.1'/><body name='arm'><joint name='j'/>"
        "<geom size='0.1'/></body></body></worldbody><keyframe>"
        "<key name='home' qpos='0 0 1 1 0 0 0 0.5'/></keyframe></mujoco>"
    )
    path = written(tmp_path / "arm.xml", text)
    findings = Findings()
    urdf, said = read_robot(path, Packages(path), {}, findings)
    assert urdf.base == "world"
    assert urdf.inboard["pelvis"].kind == "fixed"
    # Seven numbers of the keyframe are the floating body's.
    assert said.states == {"home": {"j": 0.5}}
    assert "pelvis is fixed" in dict(findings.guessed)["floating base"]


def test_what_sdformat_does_not_have_is_left_out(tmp_path):
    """Some write elements of other formats, which Drake refuses."""
    contact = "<contact><stiffness value='1'/></contact>"
    text = sdf(
        CHAIN.replace('<link name="c"/>', f'<link name="c">{contact}</link>')
    )
    urdf, findings = read(written(tmp_path / "arm.sdf", text))
    assert set(urdf.joints) >= {"j", "k"}
    said = dict(findings.guessed)["removed, not in SDFormat"]
    assert said == "<contact> in <link>"


def test_what_mjcf_says_as_an_srdf_would(tmp_path):
    text = MJCF.replace("</mujoco>", f"{EXCLUDED}{HOME}</mujoco>")
    path = mjcf(tmp_path, text)
    _, said = read_robot(path, Packages(path, {}, {}), {}, Findings())
    assert said.allowed_collisions == (("base", "lower"),)
    assert said.homes() == [("home", {"pan": 0.1, "tilt": 0.2, "slide": 0.05})]


def test_meshes_of_mjcf_are_found_and_weigh_what_they_weigh(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    (tmp_path / "shapes").mkdir()
    trimesh.creation.box((100, 200, 300)).export(tmp_path / "shapes/brick.stl")
    path = mjcf(
        tmp_path,
        '<mujoco><compiler meshdir="shapes"/>'
        '<asset><mesh file="brick.stl" scale="0.001 0.001 0.001"/></asset>'
        '<worldbody><body name="a"><joint name="j"/>'
        '<geom type="mesh" mesh="brick" density="500"/>'
        "</body></worldbody></mujoco>",
    )
    urdf, _ = read(path)
    assert urdf.name == "arm"  # Of the file, as the model has none.
    mass = float(urdf.links["a"].find("inertial/mass").get("value"))
    assert mass == pytest.approx(500 * 0.1 * 0.2 * 0.3)
    mesh = urdf.links["a"].find("collision/geometry/mesh")
    assert mesh.get("filename") == str(tmp_path / "shapes/brick.stl")
    assert mesh.get("scale") == "0.001 0.001 0.001"


FINGERS = """<body name="left_finger"><joint name="left" type="slide"
  range="0 0.04"/><geom size="0.01"/></body>
  <body name="right_finger"><joint name="right" type="slide"
  range="0 0.04"/><geom size="0.01"/></body>"""

COUPLED = '<equality><joint joint1="{}" joint2="{}" polycoef="0.01 0.5"/>'


def gripper(equality: str) -> str:
    text = MJCF.replace("<site", FINGERS + "<site")
    return text.replace("</mujoco>", f"{equality}</equality></mujoco>")


def test_a_finger_follows_and_loops_of_fingers_stay_open(tmp_path):
    loop = '<connect body1="left_finger" body2="right_finger" anchor="0 0 0"/>'
    text = gripper(COUPLED.format("right", "left") + loop)
    urdf, findings = read(mjcf(tmp_path, text))
    arm = choose_arm(urdf, Srdf(), {}, findings)
    assert arm.locked == {"left": 0.04, "right": 0.01 + 0.5 * 0.04}
    (loops,) = (x for what, x in findings.guessed if what.startswith("loops"))
    assert loops == "left_finger-right_finger"


DIRECTIVES = """
directives:
- add_model: {name: cart, file: package://shop/cart.urdf}
- add_weld:
    parent: world
    child: cart::plate
    X_PC: {translation: [0, 0, 0.5]}
- add_directives: {file: package://shop/arms.dmd.yaml}
- add_frame:
    name: tcp
    X_PF:
      base_frame: right::hook
      translation: [0, 0, 0.1]
      rotation: !Rpy { deg: [0, 90, 0] }
"""

ARMS = """
directives:
- add_model: {name: left, file: package://shop/crane.sdf}
- add_model: {name: right, file: package://shop/crane.sdf}
- add_weld:
    parent: cart::plate
    child: left::foot
    X_PC: {translation: [0, 0.4, 0.1], rotation: !Rpy { deg: [0, 0, 45] }}
- add_weld: {parent: cart::plate, child: right::foot}
"""


def shop(folder: Path, text: str = DIRECTIVES) -> Path:
    written(folder / "shop/package.xml", "<package><name>shop</name></package>")
    written(
        folder / "shop/cart.urdf",
        '<robot name="c"><link name="plate"/></robot>',
    )
    written(folder / "shop/crane.sdf", SDF)
    written(folder / "shop/arms.dmd.yaml", ARMS)
    return written(folder / "shop/robots/two.dmd.yaml", text)


def test_directives_weld_models_of_several_files(tmp_path):
    urdf, findings = read(shop(tmp_path))
    assert (urdf.name, urdf.base) == ("two", "world")
    names = [joint.name for joint in urdf.chain("tcp") if joint.moves]
    assert names == ["right_swing", "right_reach", "right_turn"]
    arms = choose_arm(urdf, Srdf(), {}, findings)
    assert arms.end_effectors == {"left": "left_tool", "right": "tcp"}
    assert not arms.locked
    arm = choose_arm(urdf, Srdf(), {"": "tcp"}, findings)
    assert set(arm.locked) == {"left_swing", "left_reach", "left_turn"}
    # Worked by hand: the cart is 0.5 m high, the left arm's foot 0.1 m more.
    text = ElementTree.tostring(urdf.root, encoding="unicode")
    plant = finalized(text, "world")
    X_WF = plant.GetFrameByName("left_foot").CalcPoseInWorld(
        plant.CreateDefaultContext()
    )
    np.testing.assert_allclose(X_WF.translation(), [0, 0.4, 0.6], atol=1e-12)
    assert X_WF.rotation().ToRollPitchYaw().yaw_angle() == pytest.approx(
        np.pi / 4
    )


LINKS = '<link name="a"/><link name="b"/><link name="c"/>'


def joint(name: str, ends: str, kind: str = "revolute", axis: str = "") -> str:
    parent, child = ends
    inner = f"<axis><xyz>0 0 1</xyz>{axis}</axis>" if kind != "ball" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent>'
        f"<child>{child}</child>{inner}</joint>"
    )


def sdf(*elements: str) -> str:
    model = f'<model name="m">{"".join(elements)}</model>'
    return f'<sdf version="1.9">{model}</sdf>'


def body(*elements: str) -> str:
    inner = f'<body name="b">{"".join(elements)}<geom size="0.1"/></body>'
    return f"<mujoco><worldbody>{inner}</worldbody></mujoco>"


CHAIN = LINKS + joint("j", "ab") + joint("k", "bc")

BAD = {
    "a loop": (
        "arm.sdf",
        sdf(CHAIN, joint("l", "ac")),
        "link 'c': is the child of 'k' and of 'l': a loop",
    ),
    "two roots": (
        "arm.sdf",
        sdf(LINKS, joint("j", "ab")),
        "link 'c': has no parent joint, and neither has 'a'; join them by a <",
    ),
    "a ball joint": (
        "arm.sdf",
        sdf(LINKS, joint("j", "ab", "ball"), joint("k", "bc")),
        "joint 'j': is ball, which cannot be driven; write type='fixed'",
    ),
    "a screw joint": (
        "arm.sdf",
        sdf(LINKS, joint("j", "ab"), joint("k", "bc", "screw")),
        "joint 'k': is screw, which cannot be driven",
    ),
    "a joint that Drake has not": (
        "arm.sdf",
        sdf(LINKS, joint("j", "ab", "gearbox"), joint("k", "bc")),
        "joint 'j'",
    ),
    "a slide without limits": (
        "arm.sdf",
        sdf(LINKS, joint("j", "ab"), joint("k", "bc", "prismatic")),
        "joint 'k' <limit>: is missing; write <limit><lower>",
    ),
    "a joint of the arm that is followed": (
        "arm.sdf",
        sdf(
            LINKS,
            joint("j", "ab"),
            joint(
                "k",
                "bc",
                axis='<mimic joint="j"><multiplier>1</multiplier></mimic>',
            ),
        ),
        "joint 'k' <mimic>: follows 'j', which the arm commands",
    ),
    "a mimic of nothing": (
        "arm.sdf",
        sdf(
            LINKS,
            joint("j", "ab"),
            joint("k", "bc", axis='<mimic joint="x"></mimic>'),
        ),
        "joint 'k' <mimic>: unknown joint 'x'",
    ),
    "a missing mesh": (
        "arm.sdf",
        sdf(
            '<link name="a"><visual name="v"><geometry><mesh>'
            "<uri>model://lost/a.stl</uri></mesh></geometry></visual></link>"
        ),
        "<mesh> <uri>: no package 'lost' .*give --package lost=DIR",
    ),
    "a model that includes itself": (
        "arm.sdf",
        sdf("<include><uri>arm.sdf</uri></include>"),
        "includes itself",
    ),
    "an included folder without a model": (
        "arm.sdf",
        sdf("<include><uri>.</uri></include>"),
        "<include> <uri> .: .* has no usable model.config",
    ),
    "a prefix that is not declared": (
        "arm.sdf",
        sdf("<drake:joint/>"),
        "broken XML: unbound prefix.*declare it, as in xmlns:drake",
    ),
    "no model": ("arm.sdf", "<sdf version='1.9'/>", "exactly one <model>"),
    "no links of a model": ("arm.xml", "<mujoco/>", "has no links"),
    "another document": (
        "arm.xml",
        "<launch/>",
        "expected <robot>, <sdf>, <mujoco>, got <launch>",
    ),
    "two bodies that float": (
        "arm.xml",
        body("<freejoint/>").replace(
            "</worldbody>",
            "<body name='cube'><freejoint/><geom size='0.1'/></body>"
            "</worldbody>",
        ),
        "<freejoint>: floats, and so do other bodies; remove all",
    ),
    "a ball joint of MJCF": (
        "arm.xml",
        body('<joint name="j" type="ball"/>'),
        "joint 'j': is ball, which cannot be driven; remove the <joint>",
    ),
    "a slide without a range": (
        "arm.xml",
        body('<joint name="j" type="slide"/>'),
        "joint 'j' range: is missing; write range='... ...' in m",
    ),
    "an element that moves others": (
        "arm.xml",
        body('<joint name="j"/><frame pos="0 0 1"><geom size="0.1"/></frame>'),
        "<frame>: Drake ignores it; .*mj_saveLastXML",
    ),
    "a missing include": (
        "arm.xml",
        "<mujoco><include file='lost.xml'/></mujoco>",
        "lost.xml: cannot be included",
    ),
    "an include of itself": (
        "arm.xml",
        "<mujoco><include file='arm.xml'/></mujoco>",
        "<include> .*arm.xml: occurs twice",
    ),
    "a coupled joint of the arm": (
        "arm.xml",
        gripper(COUPLED.format("tilt", "pan")),
        "joint 'tilt' <equality> <joint>: follows 'pan', which the arm",
    ),
    "a loop with the arm": (
        "arm.xml",
        gripper('<equality><connect body1="lower" anchor="0 0 0"/>'),
        "<equality> <connect> lower: closes a loop that contains 'pan'",
    ),
    "a missing model": (
        "arm.dmd.yaml",
        "directives:\n- add_model: {name: a, file: lost.urdf}",
        r"directives\[0\].add_model.file: lost.urdf: no such file",
    ),
    "an unknown directive": (
        "arm.yaml",
        "directives:\n- add_modle: {name: a, file: lost.urdf}",
        r"directives\[0\]: unknown directive 'add_modle' .did you mean",
    ),
    "other YAML": ("arm.yaml", "name: arm", "expected Drake's `directives:`"),
    "broken YAML": ("arm.yaml", "directives: [", "not YAML"),
    "models that nothing joins": (
        "shop/robots/two.dmd.yaml",
        "directives:\n"
        "- add_model: {name: a, file: ../crane.sdf}\n"
        "- add_model: {name: b, file: ../cart.urdf}",
        "link 'plate': has no parent joint, and neither has 'foot'.* add_weld",
    ),
    "a weld of nothing": (
        "shop/robots/two.dmd.yaml",
        "directives:\n"
        "- add_model: {name: a, file: ../crane.sdf}\n"
        "- add_weld: {parent: world, child: a::toe}",
        "no Frame named 'toe'",
    ),
}


@pytest.mark.parametrize(("name", "text", "message"), BAD.values(), ids=BAD)
def test_what_cannot_be_driven_is_one_line(
    tmp_path, monkeypatch, name, text, message
):
    mjcf(tmp_path)
    shop(tmp_path)
    written(tmp_path / name, text)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RemoSplatError, match=message) as caught:
        urdf, findings = read(Path(name))
        arm = choose_arm(urdf, Srdf(), {}, findings)
        complete_limits(urdf, arm.joints, findings)
    assert (
        str(caught.value)
        .partition(":")[0]
        .endswith("lost.xml" if "lost.xml" in message else Path(name).name)
    )
    assert "\n" not in str(caught.value)
    # Copies that are gone are not named.
    assert "import-" not in str(caught.value)
