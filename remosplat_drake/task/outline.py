"""`outline`: summarises a task and its state, for display."""

from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals import task_outline as lines
from remosplat_drake.signals.task_outline import (
    OutlineLine,
    OutlineObject,
    TaskOutline,
)
from remosplat_drake.task import task as outcomes
from remosplat_drake.task.task import Task, TaskState


def outline(task: Task, state: TaskState) -> TaskOutline:
    """Returns the jobs and objects of a task, and the present job's steps.

    Args:
        task: The task.
        state: The progress of the task.
    """
    found: list[OutlineLine] = []
    for i, block in enumerate(task.blocks):
        mark = _mark(i, state.block, state)
        found.append(OutlineLine(block.text, mark))
        if i == state.block and mark != lines.DONE:
            found += _steps(task, state)
    return TaskOutline(
        tuple(found),
        tuple(_object(task, state, each) for each in state.objects),
        state.failures,
    )


def _mark(i: int, present: int, state: TaskState) -> str:
    """Returns the state of a job or step, given the present one's index."""
    if i < present or state.outcome == outcomes.DONE:
        return lines.DONE
    if i > present:
        return lines.AHEAD
    is_over = state.outcome == outcomes.FAILED
    return lines.FAILED if is_over else lines.PRESENT


def _steps(task: Task, state: TaskState) -> list[OutlineLine]:
    """Lists the steps of the present alternative, or those that undo a step."""
    block = task.blocks[state.block]
    steps = block.ways[min(state.way, len(block.ways) - 1)]
    if len(steps) == 1 and steps[0].text == block.text:
        return []
    if state.undoing:
        steps = state.undoing
    present = 0 if state.undoing else state.step
    return [
        OutlineLine(step.text, _mark(k, present, state), True)
        for k, step in enumerate(steps)
    ]


def _object(task: Task, state: TaskState, thing: SceneObject) -> OutlineObject:
    if thing.name == state.held:
        return OutlineObject(thing.name, "carried", True, True)
    if thing.name in state.lost:
        return OutlineObject(thing.name, "lost: its place is unknown")
    rules = [rule for rule in state.rules if rule.object == thing.name]
    parts = [_permission(task, rule) for rule in rules]
    text = "; ".join(dict.fromkeys(parts)) or "nothing may touch it"
    may_be_touched = any(_touches(rule) for rule in rules)
    return OutlineObject(thing.name, text, may_be_touched)


def _touches(rule: ContactRule) -> bool:
    return rule.stopping is None or rule.stopping <= 0.0


def _permission(task: Task, rule: ContactRule) -> str:
    links = _called(task, rule.links)
    if _touches(rule):
        return f"{links} may touch it"
    return f"{links} may come as near as {1e3 * (rule.stopping or 0.0):.0f} mm"


def _called(task: Task, links: frozenset[str]) -> str:
    """Lists the names of links; "the hand" replaces all links of a hand."""
    robot = task.robot
    words, left = [], set(links)
    for i, name in enumerate(robot.effectors):
        hand = hand_links(robot, i)
        if hand <= left:
            words.append(f"the hand {name}".strip())
            left -= hand
    words += sorted(robot.description.called(link) for link in left)
    return ", ".join(words)
