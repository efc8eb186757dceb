# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments of Gazebo's spawn_model as arguments of bringup."""

from __future__ import annotations

from collections.abc import Iterator
import re

from armsim_ros.errors import Problem, Severity
from armsim_ros.model.description.xml_tree import XmlElement

#: Flag -> how many words follow it.
_FLAGS = {'-urdf': 0, '-sdf': 0, '-unpause': 0, '-wait': 1, '-model': 1, '-param': 1, '-file': 1,
          '-x': 1, '-y': 1, '-z': 1, '-R': 1, '-P': 1, '-Y': 1, '-J': 2, '-b': 0,
          '-robot_namespace': 1, '-gazebo_namespace': 1, '-reference_frame': 1,
          '-package_to_model': 0}
_RUN_TOGETHER = re.compile(r'([0-9.])(?=-[A-Za-z])')
_TURNED = {'-R': 0, '-P': 1, '-Y': 2}


def answer_spawn_model(element: XmlElement) -> Iterator[Problem]:
    """Yield what to give to bringup in place of a node that puts a model into Gazebo."""
    text = element.get('args')
    apart = _RUN_TOGETHER.sub(r'\1 ', text)
    if apart != text:
        culprit = next(word for word in text.split() if _RUN_TOGETHER.search(word))
        yield Problem(f"the words of <node args> run together at '{culprit}'; read with a space "
                      "before each '-'", element.where,
                      remedy='put the space there; line breaks were probably lost in copying',
                      severity=Severity.WARNING)
    words = apart.split()
    arguments: list[str] = []
    joints: list[str] = []
    turned = [0.0, 0.0, 0.0]
    position = 0
    while position < len(words):
        flag = words[position]
        count = _FLAGS.get(flag)
        if count is None:
            yield Problem(f"'{flag}' is not a flag of spawn_model", element.where,
                          ', '.join(_FLAGS), severity=Severity.WARNING)
            position += 1
            continue
        values = words[position + 1:position + 1 + count]
        position += 1 + count
        if len(values) < count:
            yield Problem(f"flag '{flag}' of spawn_model has too few values", element.where,
                          severity=Severity.WARNING)
        elif flag == '-model':
            arguments.append(f'robot:={values[0]}')
        elif flag in ('-x', '-y', '-z'):
            arguments.append(f'{flag[1]}:={values[0]}')
        elif flag in _TURNED:
            turned[_TURNED[flag]] = _number(values[0])
        elif flag == '-J':
            joints.append(f'{values[0]}={values[1]}')
        elif flag == '-robot_namespace':
            arguments.append(f'namespace:={values[0].strip("/")}')
        elif flag == '-file':
            arguments.append(f'urdf:={values[0]}')
    if joints:
        arguments.append(f"initial_positions:={','.join(joints)}")
    answer = f"bringup {' '.join(arguments)}".strip()
    if any(turned):
        answer += f', and placement: {{rpy: {turned}}} in simulation.yaml'
    yield Problem(f"node '{element.get('name')}' (gazebo_ros/spawn_model): {answer}",
                  element.where, severity=Severity.CHANGED)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0
