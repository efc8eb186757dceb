# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the graph shows that takes messages, with the classes of its messages."""

from __future__ import annotations

from collections.abc import Container
import copy
from dataclasses import dataclass
from importlib import import_module
import math
from random import Random
import re
from typing import Any

from rclpy.node import Node

#: Part of an action's name in the graph -> class within the action's own.
PARTS = {
    'SendGoal': 'Impl.SendGoalService', 'GetResult': 'Impl.GetResultService',
    'FeedbackMessage': 'Impl.FeedbackMessage', 'Goal': 'Goal', 'Result': 'Result',
    'Feedback': 'Feedback',
}


@dataclass(frozen=True)
class Endpoint:
    """
    Something of another node's that takes messages.

    :param node: full name of the node; of a topic, of the first that subscribes.
    :param is_service: whether it answers.
    :param name: full name of the service or topic; an action is three services.
    :param kind: class of the service or message.
    """

    node: str
    is_service: bool
    name: str
    kind: Any


def endpoints(node: Node, left_out: Container[str] = ()) -> list[Endpoint]:
    """
    Return the services and subscriptions of all nodes, sorted by name.

    :param node: that looks at the graph.
    :param left_out: names of nodes.
    """
    found: dict[tuple[bool, str], Endpoint] = {}
    for name, namespace in sorted(set(node.get_node_names_and_namespaces())):
        if name in left_out:
            continue
        served = node.get_service_names_and_types_by_node(name, namespace)
        heard = node.get_subscriber_names_and_types_by_node(name, namespace)
        full = f'{namespace.rstrip("/")}/{name}'
        for is_service, offers in ((True, served), (False, heard)):
            for endpoint, kinds in offers:
                found.setdefault(
                    (is_service, endpoint),
                    Endpoint(full, is_service, endpoint, interface(*kinds[0].split('/'))),
                )
    return [found[key] for key in sorted(found)]


def interface(package: str, section: str, name: str) -> Any:
    """Return the class of ``package/section/Name``, also of the parts of an action."""
    whole, _, part = name.partition('_')
    if part not in PARTS:
        return getattr(import_module(f'{package}.{section}'), name)
    made = getattr(import_module(f'{package}.action'), whole)
    for step in PARTS[part].split('.'):
        made = getattr(made, step)
    return made


FLOATS = (
    0.0, 1.0, -1.0, 0.5, 1e-3, 1e-12, 1e6, 1e300, -1e300, math.nan, math.inf, -math.inf, math.pi,
)
INTEGERS = {'uint8': (0, 255), 'int8': (-128, 127), 'uint16': (0, 2**16 - 1),
            'int16': (-(2**15), 2**15 - 1), 'uint32': (0, 2**32 - 1),
            'int32': (-(2**31), 2**31 - 1), 'uint64': (0, 2**64 - 1),
            'int64': (-(2**63), 2**63 - 1)}
WORDS = ('', '/', 'nobody', '<octomap>', 'a/b', 'ünï')
#: First and last character of some alphabets; none holds a NUL or half of a pair.
ALPHABETS = (' ~', '\x01\x1f', '¡ÿ', 'Ѐӿ', '\u2028\u202f', '😀😏')
MOST_ITEMS = 2


class RandomMessages:
    """
    Draws messages; the same seed draws the same ones.

    :param names: texts that mean something to whoever gets the messages.
    """

    def __init__(self, names: tuple[str, ...], seed: int = 0) -> None:
        self._names = names
        self._random = Random(seed)

    def like(self, *patterns: Any) -> Any:
        """Draw a message after one of the patterns: any of a class, or an example spoiled."""
        pattern = self._random.choice(patterns)
        return self.of_type(pattern) if isinstance(pattern, type) else self.spoiled(pattern)

    def of_type(self, made: Any) -> Any:
        """Draw a message of a class, with anything in each field."""
        return made(**{
            field: self.anything(kind)
            for field, kind in made.get_fields_and_field_types().items()})

    def spoiled(self, good: Any) -> Any:
        """Draw a good message with up to five of its parts replaced by anything."""
        result = copy.deepcopy(good)
        for _ in range(self._random.randint(1, 5)):
            self._spoil(result)
        return result

    def anything(self, kind: str) -> Any:
        """
        Draw the value of a field.

        :param kind: as ``get_fields_and_field_types`` writes it.
        """
        random = self._random
        array = re.fullmatch(r'(?:sequence<(.+?)(?:, (\d+))?>|(.+)\[(\d+)\])', kind)
        if array:
            most = min(MOST_ITEMS, int(array[2] or MOST_ITEMS))
            count = int(array[4] or random.randint(0, most))
            return [self.anything(array[1] or array[3]) for _ in range(count)]
        if kind in ('double', 'float'):
            value = random.choice((random.choice(FLOATS), random.uniform(-2.0, 2.0)))
            fits = kind == 'double' or not math.isfinite(value) or abs(value) < 1e38
            return value if fits else 0.0
        if kind == 'boolean':
            return random.random() < 0.5
        if kind in ('octet', 'byte'):
            return bytes([random.randint(0, 5)])
        if kind in INTEGERS:
            return random.choice((random.randint(0, 5), random.choice(INTEGERS[kind])))
        if kind.startswith('string'):
            return self._word()
        package, _, name = kind.partition('/')
        return self.of_type(interface(package, 'msg', name))

    def _word(self) -> str:
        """Draw a text: mostly a name that exists, also none and nonsense."""
        random = self._random
        if random.random() < 0.75:
            return random.choice((*self._names, *WORDS))
        first, last = tuple(random.choice(ALPHABETS))
        return ''.join(
            chr(random.randint(ord(first), ord(last))) for _ in range(random.randint(0, 12)))

    def _spoil(self, part: Any) -> None:
        """Replace one field somewhere in a message."""
        random = self._random
        while True:
            fields = part.get_fields_and_field_types()
            name = random.choice(sorted(fields))
            value = getattr(part, name)
            if hasattr(value, 'get_fields_and_field_types') and random.randint(0, 9):
                part = value
                continue
            inner = isinstance(value, list) and value and hasattr(
                value[0], 'get_fields_and_field_types')
            if inner and random.randint(0, 9):
                part = random.choice(value)
                continue
            setattr(part, name, self.anything(fields[name]))
            return
