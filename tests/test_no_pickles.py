"""No data is read as a pickle: it could run anything, or point anywhere."""

import ast

from sources import modules, nodes

PICKLES = {"pickle", "cPickle", "cloudpickle", "dill", "joblib", "shelve"}

OUR_PIPES = {
    "base/array_pipe.py",
    "base/kernels/compilation.py",
    "controller/guidance/rule_transfer.py",
    "recording/mcap/mcap_recorder.py",
    "recording/mcap/recording_process.py",
}
"""Modules that pickle what they tell a process of their own."""

OUR_CODE = {"base/kernels/files.py"}
"""Modules that read files of machine code, which could run anything as well.

They are the user's own, or come with the package."""


def test_only_pipes_and_machine_code_carry_pickles():
    users = set()
    for name in modules():
        for node in nodes(name):
            if isinstance(node, ast.Import):
                imported = {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported = {(node.module or "").split(".")[0]}
            else:
                continue
            if imported & PICKLES:
                users.add(name)
    assert users == OUR_PIPES | OUR_CODE


def test_what_could_read_pickles_is_told_not_to():
    loads = []
    for name in modules():
        for node in nodes(name):
            if not isinstance(node, ast.Call):
                continue
            options = {k.arg: ast.unparse(k.value) for k in node.keywords}
            assert options.get("allow_pickle", "False") == "False", name
            if ast.unparse(node.func) == "torch.load":
                loads.append(name)
                assert options.get("weights_only") == "True", name
    assert loads
