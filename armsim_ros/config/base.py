# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base of all settings (frozen, checked, unknown keys refused), and how YAML becomes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
import re
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, get_args, get_origin, get_type_hints, TypeVar, Union

from pydantic import BaseModel, ConfigDict, Field, model_validator, ValidationError

from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.errors import ignored, nearest, Problem, Severity


class Settings(BaseModel):
    """A block of settings; it never changes after it was read."""

    model_config = ConfigDict(
        frozen=True,
        extra='forbid',
        arbitrary_types_allowed=True,
        validate_default=True,
        # A robot has a few of the many blocks; the others are not made ready at each start.
        defer_build=True)


class KeyedSettings(Settings):
    """Settings that besides their own keys hold a block per name, such as one for each joint."""

    model_config = ConfigDict(extra='allow')
    #: What a key is not that is neither its own nor a block.
    is_no: ClassVar[str] = 'parameter, and no block'

    @model_validator(mode='before')
    @classmethod
    def _only_blocks_beside(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            for key, value in data.items():
                if key not in cls.model_fields and not isinstance(value, (Mapping, Settings)):
                    hint = nearest(str(key), tuple(cls.model_fields))
                    raise ValueError(f"'{key}' is not a {cls.is_no}{'; ' if hint else ''}{hint}")
        return data


def parameter(
    default: Any = ..., description: str = '', *, read_only: bool = False,
    on_configure: bool = False, **constraints: Any
) -> Any:
    """
    Declare a field that is also a ROS parameter.

    :param default: the default; ``...`` where the user must give a value.
    :param description: what it means, with the unit in brackets.
    :param read_only: whether it keeps its value after the controller was loaded.
    :param on_configure: whether a new value takes effect when the controller is configured.
    :param constraints: pydantic's ``ge``, ``gt``, ``le``, ``lt``, ``alias`` ...
    """
    return Field(
        default, description=description,
        json_schema_extra={'read_only': read_only, 'on_configure': on_configure}, **constraints)


def fixed(default: Any = ..., description: str = '', **constraints: Any) -> Any:
    """Declare a field whose ROS parameter keeps its value after the controller was loaded."""
    return parameter(default, description, read_only=True, **constraints)


def configured(default: Any = ..., description: str = '', **constraints: Any) -> Any:
    """Declare a field whose ROS parameter takes effect when the controller is configured."""
    return parameter(default, description, on_configure=True, **constraints)


def unique_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """
    Return the names.

    :raises ValueError: an entry is defined twice.
    """
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f'named twice: {", ".join(twice)}')
    return names


def are_names(value: Any) -> bool:
    """Return whether a value that is not checked yet is a list of texts."""
    return isinstance(value, (list, tuple)) and all(isinstance(name, str) for name in value)


def entry_per_name(names: Any, entries: Any) -> Any:
    """
    Return name -> entry, with an empty entry for each name that has none.

    Clients get every parameter before they set it. Entries are returned as they are where they or
    the names have the wrong type, which the check of the field reports.

    :param names: a list of texts.
    :param entries: a block of keys; None is an empty block.
    """
    if not are_names(names) or not isinstance(entries, (Mapping, NoneType)):
        return entries
    return {**{name: {} for name in names}, **(entries or {})}


class ControllerParameters(Settings):
    """The base of the parameters of all kinds of controllers."""

    update_rate: int = parameter(
        0, "updates per second, by default the manager's rate [Hz]", read_only=True, ge=0)
    is_async: bool = parameter(
        False, 'has no effect: all controllers run in the same control loop', read_only=True)
    thread_priority: int = parameter(
        -100, 'has no effect: all controllers run in the same control loop', read_only=True)


class StandInParameters(ControllerParameters):
    """Parameters that a replacement reads; all others are the vendor's and ignored."""

    model_config = ConfigDict(extra='ignore')

    state_publish_rate: float = parameter(
        100.0, 'messages a second, where it publishes anything [Hz]', read_only=True, gt=0.0)


class FreedriveModeControllerParameters(StandInParameters):
    """Parameters of ``ur_controllers/FreedriveModeController``."""

    inactive_timeout: int = parameter(
        1, 'freedrive ends so long after the last message that asked for it [s]', ge=0)


AnySettings = TypeVar('AnySettings', bound=BaseModel)

#: Longer lists of names are left out of a message that has a hint already.
MOST_NAMES_SHOWN = 10

_QUOTED = re.compile(r"(?:^(\w+)(?:: | ))?.*?'([^']+)'")
_WANTED = {
    'float': 'a number',
    'int': 'a whole number',
    'bool': 'true or false',
    'string_type': 'a text',
    'tuple_type': 'a list',
    'list_type': 'a list',
    'dict_type': 'a block of keys',
    'model': 'a block of keys',
    'finite_number': 'a finite number',
}
_ONE_OF = re.compile(r'^Input should be (.+)$')


def read_settings(
    kind: type[AnySettings], node: YamlNode, problems: list[Problem], *, title: str,
    unused: Mapping[str, str] | None = None, tolerant: bool = True, published: bool = False
) -> AnySettings | None:
    """
    Return a block as checked settings, None where it has errors.

    :param problems: errors and remarks are added here.
    :param title: what the block is, for messages, such as "controller 'arm'".
    :param unused: keys that other programs of the stack read and this program does not -> why;
        each gives a remark and is left out.
    :param tolerant: whether an unknown key is left out, as upstream does, or is an
        error, as in files that only this package has.
    :param published: whether the file is published, so that its reader will not change: a value
        with an error has its default, and the others count.
    """
    if not node.is_mapping:
        problems.append(Problem(f'{title} is {node.kind}', node.place, 'a block of keys'))
        return None
    node = drop_unused(node, unused or {}, problems, title=title)
    if _add_nans(node, problems, title):
        return None
    known_unused = tuple(unused or ())
    try:
        return kind.model_validate(node.plain())
    except ValidationError as error:
        details = error.errors(include_url=False)
    extra = [detail for detail in details if detail['type'] == 'extra_forbidden']
    if extra and tolerant:
        # As upstream, unknown keys are ignored.
        problems.extend(ignored(_problem(kind, node, detail, title, known_unused))
                        for detail in extra)
        paths = [_written_path(node, detail['loc']) for detail in extra]
        return read_settings(kind, _without(node, paths), problems, title=title, unused=unused,
                             published=published)
    inner = {detail['loc'][:-1] for detail in details}
    for detail in details:
        if detail['type'] == 'too_short' and detail['loc'] in inner:
            continue  # its items are there, but wrong
        problems.append(_problem(kind, node, detail, title, known_unused))
    faults = [_fault(node, detail) for detail in details]
    if not published or [] in faults:
        return None
    return read_settings(kind, _without(node, faults), problems, title=title, unused=unused,
                         tolerant=tolerant, published=True)


def drop_unused(
    node: YamlNode, unused: Mapping[str, str], problems: list[Problem], *, title: str
) -> YamlNode:
    """Return a mapping without the keys that nothing here reads; each gives a remark."""
    found = [key for key in node.entries if key in unused]
    for key in found:
        reason = f': {unused[key]}' if unused[key] else ''
        problems.append(Problem(f"{title}: '{key}' is not used here{reason}",
                                node.entries[key].place, severity=Severity.INFO))
    return node.without(*found) if found else node


def _without(node: YamlNode, paths: Sequence[Sequence[str | int]]) -> YamlNode:
    """Return a mapping without the entries at some paths."""
    for path in paths:
        node = _cut(node, path)
    return node


def _fault(node: YamlNode, detail: Any) -> list[str | int]:
    """Return the path to the smallest entry that an error leaves out, [] for the whole block."""
    path = _written_path(node, detail['loc'])
    if detail['type'] == 'value_error':
        path = _refine(node, path, str(detail['ctx']['error'])) or path
    path = path[:node.find(path)[1]]
    while path and isinstance(path[-1], int):
        path.pop()  # a list counts as a whole
    return path


def _cut(node: YamlNode, path: Sequence[str | int]) -> YamlNode:
    step, *rest = path
    if isinstance(step, int) and step < len(node.items):
        items = list(node.items)
        items[step] = _cut(items[step], rest)
        return replace(node, value=tuple(items))
    if not rest:
        return node.without(str(step))
    inner = node.get(str(step))
    if inner is None:
        return node
    return node.with_value({**node.entries, str(step): _cut(inner, rest)})


def known_keys(kind: type[BaseModel]) -> tuple[str, ...]:
    """Return the keys that a block of settings may have."""
    return tuple(field.alias or name for name, field in kind.model_fields.items())


def _add_nans(node: YamlNode, problems: list[Problem], title: str) -> bool:
    found = [inner for inner in node.walk()
             if isinstance(inner.value, float) and math.isnan(inner.value)]
    problems.extend(Problem(f"{title}: '{inner.text}' is not a number", inner.where,
                            'a number') for inner in found)
    return bool(found)


def _problem(kind: type[BaseModel], node: YamlNode, detail: Any, title: str,
             unused: Sequence[str]) -> Problem:
    path = _written_path(node, detail['loc'])
    name = '.'.join(str(step) for step in path)
    culprit, steps = node.find(path)
    where = culprit.place
    given = culprit if steps == len(path) and path else None
    if detail['type'] == 'extra_forbidden':
        known = [*keys_at(kind, path[:-1]), *unused]
        hint = nearest(str(path[-1]), known)
        allowed = ', '.join(known) if len(known) <= MOST_NAMES_SHOWN or not hint else ''
        return Problem(f"{title}: key '{name}' is not known", where, allowed, hint)
    if detail['type'] == 'missing':
        if isinstance(path[-1], int):
            return Problem(f"{title}: '{name.rpartition('.')[0]}' has too few values", where)
        return Problem(f"{title}: '{name}' is missing", where, remedy=f"add '{path[-1]}:'")
    if detail['type'] == 'value_error':
        text = str(detail['ctx']['error'])
        refined = _refine(node, path, text)
        head = f'{title}: {name}: ' if name else f'{title}: '
        return Problem(head + text, node.locate(refined) if refined else where)
    what = f"{title}: '{name}' is {given.kind}" if given else f'{title}: {name}'
    remedy = ''
    if given is not None and isinstance(given.value, bool) and given.text.lower() not in (
            'true', 'false'):
        remedy = f'YAML reads {given.text} as {str(given.value).lower()}: put it in quotes'
    return Problem(what, given.where if given else where, _allowed(detail), remedy)


def _written_path(node: YamlNode, loc: Sequence[str | int]) -> list[str | int]:
    """Return pydantic's path without the steps that denote a member of a union."""
    path: list[str | int] = []
    for position, step in enumerate(loc):
        _, steps = node.find([*path, step])
        last = position == len(loc) - 1
        if steps == len(path) + 1 or last:
            path.append(step)
    return path


def _refine(node: YamlNode, path: Sequence[str | int], text: str) -> list[str | int] | None:
    """Return the path of the word that a message quotes, where it can be found."""
    match = _QUOTED.match(text)
    if match is None:
        return None
    key, word = match[1], match[2]
    for steps in ([*path, key, word], [*path, word], [*path, key]):
        known = [step for step in steps if step is not None]
        if len(known) == len(steps) and node.locate(known) is not None:
            return known
    above = [*path, key] if key else [*path]
    parent, found = node.find(above)
    places = [place for place, item in enumerate(parent.items) if item.value == word]
    return [*above[:found], places[0]] if places else None


def keys_at(kind: type[BaseModel], path: Sequence[str | int]) -> tuple[str, ...]:
    """Return the keys that are known at a path inside a block of settings."""
    inside: Any = kind
    for step in path:
        if isinstance(inside, type) and issubclass(inside, BaseModel):
            field = inside.model_fields.get(str(step))
            extra = get_type_hints(inside).get('__pydantic_extra__')
            inside = field.annotation if field else _last_type(extra)
        else:
            inside = _last_type(inside)
        if get_origin(inside) in (Union, UnionType, Annotated):
            inside = get_args(inside)[0]
    return known_keys(inside) if isinstance(inside, type) and issubclass(inside, BaseModel) else ()


def _last_type(annotation: Any) -> Any:
    """Return the class of the values in ``dict[str, X]`` or ``tuple[X, ...]``."""
    arguments = [item for item in get_args(annotation) if item is not Ellipsis]
    return arguments[-1] if arguments else None


def _allowed(detail: Any) -> str:
    """Return what pydantic expected, as a phrase."""
    kind, context = str(detail['type']), detail.get('ctx', {})
    for start, phrase in _WANTED.items():
        if kind.startswith(start):
            return phrase
    if kind in ('too_short', 'too_long'):
        bound = context.get('min_length', context.get('max_length'))
        return f"a list with at {'least' if kind == 'too_short' else 'most'} {bound} values"
    if kind == 'union_tag_invalid':
        return f"{context['discriminator'].strip(chr(39))}: {context['expected_tags']}"
    if kind == 'union_tag_not_found':
        return f"a block with the key {context['discriminator']}"
    match = _ONE_OF.match(str(detail['msg']))
    return match[1] if match else str(detail['msg'])
