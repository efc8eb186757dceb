# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The syntax of launch files in XML and YAML: elements, those of ROS 1, texts with ``$(...)``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import re
from typing import Any

from armsim_ros.errors import Location, nearest
from armsim_ros.launch.api import launches, paths, programs, substitutions
from armsim_ros.launch.api.context import coerce, Substitution, TextSubstitution
from armsim_ros.launch.failures import LaunchError


class Element:
    """
    Attributes and children.

    :param name: of the element.
    :param attributes: texts; in YAML also numbers, truths and lists.
    :param where: its line.
    :param is_typed: whether attributes have the types that the file writes, as in YAML.
    """

    def __init__(
        self, name: str, attributes: Mapping[str, Any], children: Sequence[Element] = (),
        where: Location | None = None, *, is_typed: bool = False
    ) -> None:
        self.type_name, self.is_typed = name, is_typed
        self.attributes = dict(attributes)
        self.children = list(children)
        self.where = where
        self.read: set[str] = set()

    def all(self, name: str) -> list[Element]:
        """Return the children of a name."""
        return [child for child in self.children if child.type_name == name]

    def get_attr(self, name: str, *, data_type: Any = str, optional: bool = False,
                 can_be_str: bool = True) -> Any:
        """
        Return an attribute, or the children of a name where a list is asked for.

        :raises LaunchError: where it is required but missing.
        """
        self.read.add(name)
        if data_type is list or getattr(data_type, '__origin__', None) is list:
            found = self.all(name)
            if found or name not in self.attributes:
                if not found and not optional:
                    raise LaunchError(f'<{self.type_name}> needs <{name}> inside', self.where)
                return found or None
        if name in self.attributes:
            value = self.attributes[name]
            return value if data_type is str else coerce(value, data_type)
        if optional:
            return None
        raise LaunchError(f"<{self.type_name}> needs the attribute '{name}'", self.where)

    def text(self, name: str) -> str | None:
        """Return an attribute as a text, None where it is not there."""
        value = self.get_attr(name, optional=True)
        if value is None:
            return None
        if isinstance(value, bool):
            return str(value).lower()
        return str(value)

    def assert_entity_completely_parsed(self) -> None:
        """Do nothing: unread attributes are not an error."""


_MARKS = ('rosparam', 'param', 'machine', 'test', 'env', 'remap')


def is_ros1(root: Element) -> bool:
    """Return whether a file is one of ROS 1: nodes by type, parameters outside of nodes."""
    for child in root.children:
        if child.type_name in _MARKS:
            return True
        if child.type_name == 'node' and 'type' in child.attributes:
            return True
        if any('$(arg ' in str(value) or '$(find ' in str(value)
               for value in child.attributes.values()):
            return True
        if child.type_name in ('group', 'include') and is_ros1(child):
            return True
    return False


def translate(root: Element) -> Element:
    """
    Return the elements translated into those of ROS 2.

    Parameters of the parameter server become those of all nodes after them; files of parameters
    likewise. ``required`` becomes ``on_exit="shutdown"``.
    """
    return Element(root.type_name, root.attributes, [
        translated for child in root.children for translated in _translated(child)], root.where)


def _translated(element: Element) -> list[Element]:
    name, attributes = element.type_name, dict(element.attributes)
    if name in ('machine', 'test'):
        return []
    if name == 'arg':
        if 'value' in attributes:
            return [Element('let', {**attributes}, [], element.where)]
        if 'doc' in attributes:
            attributes['description'] = attributes.pop('doc')
        return [Element('arg', attributes, [], element.where)]
    if name == 'env':
        return [Element('set_env', attributes, [], element.where)]
    if name == 'remap':
        return [Element('set_remap', attributes, [], element.where)]
    if name == 'param':
        return _parameter(element)
    if name == 'rosparam':
        return _file(element)
    children = [inner for child in element.children for inner in _inside(name, child)]
    if name == 'group' and 'ns' in attributes:
        push = Element('push_ros_namespace', {'namespace': attributes.pop('ns')}, [],
                       element.where)
        children.insert(0, push)
    if name == 'include':
        attributes.pop('pass_all_args', None)
        attributes.pop('clear_params', None)
    return [Element(name, attributes, children, element.where)]


def _inside(parent: str, element: Element) -> list[Element]:
    if parent not in ('node', 'include'):
        return _translated(element)
    if parent == 'include' or element.type_name in ('remap', 'env'):
        return [element]
    if element.type_name == 'rosparam':
        file = element.attributes.get('file')
        return [Element('param', {'from': file}, [], element.where)] if file else []
    if element.type_name == 'param':
        return [] if 'value' not in element.attributes else [
            Element('param', {**element.attributes, 'name': _dotted(element)}, [], element.where)]
    return []


def _parameter(element: Element) -> list[Element]:
    value = element.attributes.get('value')
    if 'command' in element.attributes:
        value = f"$(command '{element.attributes['command']}')"
    elif 'textfile' in element.attributes:
        value = f"$(file-content {element.attributes['textfile']})"
    if value is None:
        return []
    kept = _condition(element)
    kind = element.attributes.get('type')
    if 'command' in element.attributes or 'textfile' in element.attributes:
        kind = 'str'
    kinds = {'string': 'str', 'str': 'str', 'double': 'float', 'int': 'int', 'bool': 'bool'}
    if kind in kinds:
        kept['type'] = kinds[kind]
    return [Element('set_parameter', {'name': _dotted(element), 'value': value, **kept}, [],
                    element.where)]


def _file(element: Element) -> list[Element]:
    file = element.attributes.get('file')
    if file is None or element.attributes.get('command', 'load') != 'load':
        return []
    kept = _condition(element)
    return [Element('set_parameters_from_file', {'filename': file, **kept}, [], element.where)]


def _condition(element: Element) -> dict[str, Any]:
    return {key: value for key, value in element.attributes.items() if key in ('if', 'unless')}


def _dotted(element: Element) -> str:
    return str(element.attributes.get('name', '')).strip('/').replace('/', '.')


Argument = list[Substitution]


def _env(words: Sequence[Argument]) -> Substitution:
    return substitutions.EnvironmentVariable(
        words[0], default_value=_joined(words[1:]) if len(words) > 1 else None)


def _optional_env(words: Sequence[Argument]) -> Substitution:
    return substitutions.EnvironmentVariable(words[0], default_value=_joined(words[1:]))


def _var(words: Sequence[Argument]) -> Substitution:
    return substitutions.LaunchConfiguration(
        words[0], default=_joined(words[1:]) if len(words) > 1 else None)


def _command(words: Sequence[Argument]) -> Substitution:
    handling = words[-1] if len(words) > 1 else None
    if handling is not None and _plain(handling) in ('warn', 'ignore', 'fail', 'capture'):
        return programs.Command(_joined(words[:-1]), on_stderr=_plain(handling))
    return programs.Command(_joined(words))


def _eval(words: Sequence[Argument]) -> Substitution:
    if len(words) == 2 and _MODULES.fullmatch(_plain(words[1])):
        modules = [name.strip() for name in _plain(words[1]).split(',')]
        return programs.PythonExpression(words[0], modules)
    return programs.PythonExpression(_joined(words))


#: The second argument of ``$(eval 'expression' 'modules')``.
_MODULES = re.compile(r'[\w.]+(\s*,\s*[\w.]+)*')
#: Name -> function that makes the substitution from its arguments.
KINDS: dict[str, Callable[[Sequence[Argument]], Substitution]] = {
    'var': _var,
    'arg': _var,
    'env': _env,
    'optenv': _optional_env,
    'find-pkg-share': lambda words: paths.FindPackageShare(words[0]),
    'find': lambda words: paths.FindPackageShare(words[0]),
    'find-pkg-prefix': lambda words: paths.FindPackagePrefix(words[0]),
    'find-pkg': lambda words: paths.FindPackagePrefix(words[0]),
    'find-exec': lambda words: programs.FindExecutable(name=words[0]),
    'exec-in-pkg': lambda words: paths.ExecutableInPackage(words[0], words[1]),
    'dirname': lambda words: paths.ThisLaunchFileDir(),
    'filename': lambda words: paths.ThisLaunchFile(),
    'log_dir': lambda words: paths.LaunchLogDir(),
    'log-dir': lambda words: paths.LaunchLogDir(),
    'launch_log_dir': lambda words: paths.LaunchLogDir(),
    'eval': _eval,
    'command': _command,
    'anon': lambda words: substitutions.AnonName(words[0]),
    'not': lambda words: substitutions.NotSubstitution(words[0]),
    'and': lambda words: substitutions.AndSubstitution(*words),
    'or': lambda words: substitutions.OrSubstitution(*words),
    'any': lambda words: substitutions.AnySubstitution(*words),
    'all': lambda words: substitutions.AllSubstitution(*words),
    'equals': lambda words: substitutions.EqualsSubstitution(words[0], words[1]),
    'not-equals': lambda words: substitutions.NotEqualsSubstitution(words[0], words[1]),
    'file-content': lambda words: paths.FileContent(words[0]),
    'if': lambda words: substitutions.IfElseSubstitution(
        words[0], words[1], words[2] if len(words) > 2 else ''),
    'for-var': lambda words: substitutions.ForEachVar(
        _plain(words[0]), words[1] if len(words) > 1 else None),
    'index': lambda words: substitutions.ForLoopIndex(_plain(words[0])),
    'param': lambda words: paths.Parameter(
        words[0], default=words[1] if len(words) > 1 else None),
    'xacro': lambda words: launches.Xacro(words[0]),
    'local': lambda words: substitutions.LocalSubstitution(_plain(words[0])),
}


def parse_substitution(text: str, more: dict[str, Any] | None = None) -> list[Substitution]:
    """
    Return a text with ``$(...)`` in it as substitutions.

    :param more: name -> substitution class of the user's.
    :raises LaunchError: for a name that is not known, or a bracket that is not closed.
    """
    found, rest = _sequence(text, 0, more or {}, '')
    assert rest == len(text)
    return found or [TextSubstitution(text='')]


def _sequence(text: str, start: int, more: dict[str, Any], ends: str, *, quoted: bool = False
              ) -> tuple[list[Substitution], int]:
    """Read until an end sign that is not in brackets, or the quote; return parts and its place."""
    parts: list[Substitution] = []
    letters: list[str] = []
    depth = 0
    position = start
    while position < len(text):
        sign, following = text[position], text[position + 1:position + 2]
        if sign == '\\' and (following if quoted else following in {'$', '\\'}):
            letters.append(following)
            position += 2
            continue
        if text.startswith('$(', position):
            if letters:
                parts.append(TextSubstitution(text=''.join(letters)))
                letters = []
            substitution, position = _substitution(text, position + 2, more)
            parts.append(substitution)
            continue
        if depth == 0 and sign in ends:
            break
        if not quoted:
            depth += (sign == '(') - (sign == ')')
        letters.append(sign)
        position += 1
    if letters:
        parts.append(TextSubstitution(text=''.join(letters)))
    return parts, position


def _substitution(text: str, start: int, more: dict[str, Any]) -> tuple[Substitution, int]:
    """Read what follows ``$(``; return it and the place after its bracket."""
    position = start
    while position < len(text) and (text[position].isalnum() or text[position] in '-_'):
        position += 1
    name = text[start:position]
    words: list[Argument] = []
    while True:
        while position < len(text) and text[position].isspace():
            position += 1
        if position >= len(text):
            raise LaunchError(f"'$({name}' has no closing bracket")
        if text[position] == ')':
            position += 1
            break
        if name == 'eval' and text[position] not in '\'"':
            word, position = _sequence(text, position, more, ')')
        elif text[position] in '\'"':
            word, position = _sequence(text, position + 1, more, text[position], quoted=True)
            if position == len(text):
                raise LaunchError(f"a quote is not closed in '{text}'")
            word, position = word or [TextSubstitution(text='')], position + 1
        else:
            word, position = _sequence(text, position, more, ') \t\r\n')
        words.append(word)
    return _make(name, words, more), position


def _make(name: str, words: list[Argument], more: dict[str, Any]) -> Substitution:
    if name in more:
        kind, kwargs = more[name].parse(words)
        made: Substitution = kind(**kwargs)
        return made
    make = KINDS.get(name)
    if make is None:
        hint = nearest(name, tuple(KINDS)) or f"known: {', '.join(KINDS)}"
        raise LaunchError(f"substitution '$({name})' is not known; {hint}")
    try:
        return make(words)
    except IndexError:
        raise LaunchError(f"'$({name})' needs more words") from None


def _joined(words: Sequence[Argument]) -> Argument:
    joined: Argument = []
    for word in words:
        if joined:
            joined.append(TextSubstitution(text=' '))
        joined += word
    return joined or [TextSubstitution(text='')]


def _plain(word: Argument) -> str:
    return ''.join(part.text for part in word if isinstance(part, TextSubstitution))
