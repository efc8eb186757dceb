# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Builds actions from the elements of XML and YAML files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
import shlex
from typing import Any, ClassVar

from armsim_ros.errors import nearest
from armsim_ros.launch.api import actions, configuration, event_handlers, ros_node
from armsim_ros.launch.api.configuration import IfCondition, UnlessCondition
from armsim_ros.launch.api.context import LaunchDescriptionEntity, Substitution, TextSubstitution
from armsim_ros.launch.api.description import (
    AnyLaunchDescriptionSource,
    IncludeLaunchDescription,
    LaunchDescription,
)
from armsim_ros.launch.api.process import ExecuteProcess
from armsim_ros.launch.api.ros_parameters import ParameterFile, ParameterValue
from armsim_ros.launch.failures import LaunchError
from armsim_ros.launch.syntax import Element, parse_substitution

Entity = LaunchDescriptionEntity
#: Element -> its action, and the attribute of each argument, with other names that it may have.
_OF_TEXTS: dict[str, tuple[Any, ...]] = {
    'let': (configuration.SetLaunchConfiguration, 'name', 'value'),
    'unset': (configuration.UnsetLaunchConfiguration, 'name'),
    'set_env': (configuration.SetEnvironmentVariable, 'name', 'value'),
    'unset_env': (configuration.UnsetEnvironmentVariable, 'name'),
    'push_ros_namespace': (ros_node.PushRosNamespace, 'namespace ns'),
    'set_parameters_from_file': (ros_node.SetParametersFromFile, 'filename'),
    'set_remap': (ros_node.SetRemap, 'from', 'to'),
    'set_ros_log_dir': (ros_node.SetROSLogDir, 'new_log_dir'),
}


class Parser:
    """Builds the actions of a file."""

    #: What users' packages add: name -> class or function.
    actions: ClassVar[dict[str, Any]] = {}
    substitutions: ClassVar[dict[str, Any]] = {}

    def parse_description(self, root: Element) -> LaunchDescription:
        """Return the description of a file."""
        return LaunchDescription(self._all(root.children))

    def parse_substitution(self, value: Any) -> list[Substitution]:
        """Return a text as substitutions."""
        text = str(value).lower() if isinstance(value, bool) else str(value)
        return parse_substitution(text, self.substitutions)

    def parse_if_substitutions(self, value: Any) -> Any:
        """Return a text with ``$(...)`` as substitutions, other values as they are."""
        if isinstance(value, list):
            return [self.parse_if_substitutions(item) for item in value]
        if not isinstance(value, str):
            return value
        first, *others = parts = self.parse_substitution(value)
        return first.text if isinstance(first, TextSubstitution) and not others else parts

    def escape_characters(self, value: Any) -> str:
        """Return a text without its backslashes."""
        return str(value).replace('\\\\', '\0').replace('\\', '').replace('\0', '\\')

    def condition_of(self, element: Element) -> Any:
        """Return the condition of an element, None if there is none."""
        when, unless = element.text('if'), element.text('unless')
        if when is not None and unless is not None:
            raise LaunchError("'if' and 'unless' exclude each other", element.where)
        if when is not None:
            return self._at(IfCondition(self.parse_substitution(when)), element)
        if unless is not None:
            return self._at(UnlessCondition(self.parse_substitution(unless)), element)
        return None

    def parse_action(self, element: Element) -> Entity:
        """
        Return the action of an element.

        :raises LaunchError: where it is none.
        """
        made = self._made(element)
        made.where = element.where
        return made

    def _made(self, element: Element) -> Entity:
        name = element.type_name.replace('-', '_')
        own = self.actions.get(element.type_name)
        try:
            if own is not None:
                parse = own.parse if hasattr(own, 'parse') else own
                kind, kwargs = parse(element, self)
                made: Entity = kind(**kwargs)
                return made
            if name in _OF_TEXTS:
                action, *attributes = _OF_TEXTS[name]
                made = action(*(self._text(element, *names.split()) for names in attributes),
                              condition=self.condition_of(element))
                return made
            make: Callable[[Element], Entity] | None = getattr(self, f'_make_{name}', None)
            if make is not None:
                return make(element)
        except LaunchError as failure:
            raise failure.at(element.where) from None
        known = sorted([*_OF_TEXTS, *(method.removeprefix('_make_') for method in dir(self)
                                      if method.startswith('_make_'))])
        hint = nearest(name, known) or f"known: {', '.join(known)}"
        raise LaunchError(f'<{element.type_name}> is not an element of a launch file; {hint}',
                            element.where)

    def _all(self, elements: Iterable[Element]) -> list[Entity]:
        return [self.parse_action(element) for element in elements]

    def _at(self, made: Any, element: Element) -> Any:
        made.where = element.where
        return made

    def _text(self, element: Element, *names: str) -> list[Substitution]:
        for name in names:
            value = element.text(name)
            if value is not None:
                return self.parse_substitution(value)
        raise LaunchError(f"<{element.type_name}> needs the attribute '{names[0]}'",
                            element.where)

    def _optional(self, element: Element, name: str) -> list[Substitution] | None:
        value = element.text(name)
        return None if value is None else self.parse_substitution(value)

    # Arguments, configurations, environment -----------------------------------------------------

    def _make_arg(self, element: Element) -> Entity:
        kind, kwargs = configuration.DeclareLaunchArgument.parse(element, self)
        made: Entity = kind(**kwargs)
        return made

    def _make_append_env(self, element: Element) -> Entity:
        return configuration.AppendEnvironmentVariable(
            self._text(element, 'name'), self._text(element, 'value'),
            prepend=(element.text('prepend') or 'false').lower() == 'true',
            condition=self.condition_of(element))

    def _make_reset(self, element: Element) -> Entity:
        return configuration.ResetLaunchConfigurations(
            self._kept(element), condition=self.condition_of(element))

    def _make_reset_env(self, element: Element) -> Entity:
        return configuration.ResetEnvironment(condition=self.condition_of(element))

    def _kept(self, element: Element) -> dict[str, list[Substitution]]:
        return {child.get_attr('name'): self._text(child, 'value')
                for child in element.all('keep')}

    # Structure ----------------------------------------------------------------------------------

    def _make_group(self, element: Element) -> Entity:
        inside = [child for child in element.children if child.type_name != 'keep']
        return actions.GroupAction(
            self._all(inside), scoped=_truth(element, 'scoped', True),
            forwarding=_truth(element, 'forwarding', True),
            launch_configurations=self._kept(element), condition=self.condition_of(element))

    def _make_include(self, element: Element) -> Entity:
        source = self._at(AnyLaunchDescriptionSource(self._text(element, 'file')), element)
        pairs = [(child.get_attr('name'), self._text(child, 'value', 'default'))
                 for child in (*element.all('arg'), *element.all('let'))]
        included = IncludeLaunchDescription(
            source, launch_arguments=pairs, condition=self.condition_of(element))
        namespace = element.text('ns')
        if namespace is None:
            return included
        included.where = element.where
        return actions.GroupAction(
            [ros_node.PushRosNamespace(self.parse_substitution(namespace)), included])

    def _make_timer(self, element: Element) -> Entity:
        kind = event_handlers.RosTimer if element.type_name == 'ros_timer' \
            else event_handlers.TimerAction
        return kind(period=self._text(element, 'period'), actions=self._all(element.children),
                    condition=self.condition_of(element))

    _make_ros_timer = _make_timer

    def _make_for(self, element: Element) -> Entity:
        if 'len' in element.attributes:
            return actions.ForLoop(
                self._text(element, 'len'), name=element.get_attr('name'),
                entities=self._all(element.children), condition=self.condition_of(element))
        return actions.ForEach(
            self._text(element, 'values'), entities=self._all(element.children),
            condition=self.condition_of(element))

    _make_for_each = _make_for

    def _make_log(self, element: Element) -> Entity:
        return actions.LogInfo(msg=self._text(element, 'message'),
                               level=element.text('level') or 'info',
                               condition=self.condition_of(element))

    def _make_shutdown(self, element: Element) -> Entity:
        return event_handlers.Shutdown(reason=self._optional(element, 'reason') or '',
                                condition=self.condition_of(element))

    # Processes ----------------------------------------------------------------------------------

    def _make_executable(self, element: Element) -> Entity:
        words = [self.parse_substitution(word) for word in _words(element.get_attr('cmd'))]
        return ExecuteProcess(cmd=words, **self._process(element))

    def _make_node(self, element: Element) -> Entity:
        return ros_node.Node(**self._node(element))

    def _make_lifecycle_node(self, element: Element) -> Entity:
        kwargs = self._node(element)
        kwargs.setdefault('namespace', '')
        return ros_node.LifecycleNode(**kwargs)

    def _make_node_container(self, element: Element) -> Entity:
        return ros_node.ComposableNodeContainer(
            composable_node_descriptions=self._components(element), **self._node(element))

    def _make_load_composable_node(self, element: Element) -> Entity:
        return ros_node.LoadComposableNodes(
            target_container=self._text(element, 'target'),
            composable_node_descriptions=self._components(element),
            condition=self.condition_of(element))

    def _components(self, element: Element) -> list[Any]:
        return [ros_node.ComposableNode(
            package=self._text(node, 'pkg'), plugin=self._text(node, 'plugin'),
            name=self._optional(node, 'name'), namespace=self._optional(node, 'namespace'),
            parameters=self._parameters(node), remappings=self._remappings(node),
            condition=self.condition_of(node)) for node in element.all('composable_node')]

    def _process(self, element: Element) -> dict[str, Any]:
        given: dict[str, Any] = {'output': self._optional(element, 'output') or 'log'}
        for name, keyword in (
                ('name', 'name'), ('cwd', 'cwd'), ('launch-prefix', 'prefix'),
                ('respawn', 'respawn'), ('respawn_delay', 'respawn_delay'),
                ('respawn_max_retries', 'respawn_max_retries'),
                ('emulate_tty', 'emulate_tty'), ('sigterm_timeout', 'sigterm_timeout'),
                ('sigkill_timeout', 'sigkill_timeout')):
            value = self._optional(element, name)
            if value is not None:
                given[keyword] = value
        if 'shell' in element.attributes:
            given['shell'] = _truth(element, 'shell', False)
        if element.text('on_exit') == 'shutdown' or element.text('required') == 'true':
            given['on_exit'] = [event_handlers.Shutdown()]
        variables = {child.get_attr('name'): self._text(child, 'value')
                     for child in element.all('env')}
        if variables:
            given['additional_env'] = variables
        condition = self.condition_of(element)
        if condition is not None:
            given['condition'] = condition
        return given

    def _node(self, element: Element) -> dict[str, Any]:
        given = self._process(element)
        given.pop('name', None)
        for names, keyword in ((('pkg',), 'package'), (('exec', 'type'), 'executable')):
            given[keyword] = self._text(element, *names)
        for attribute, keyword in (('name', 'name'), ('namespace', 'namespace'),
                                   ('ns', 'namespace'), ('exec_name', 'exec_name')):
            value = self._optional(element, attribute)
            if value is not None:
                given[keyword] = value
        given['arguments'] = [self.parse_substitution(word)
                              for word in _words(element.text('args') or '')]
        given['ros_arguments'] = [self.parse_substitution(word)
                                  for word in _words(element.text('ros_args') or '')]
        given['parameters'] = self._parameters(element)
        given['remappings'] = self._remappings(element)
        return given

    def _remappings(self, element: Element) -> list[tuple[Any, Any]]:
        return [(self._text(child, 'from'), self._text(child, 'to'))
                for child in element.all('remap')]

    def _parameters(self, element: Element) -> list[Any]:
        return [self._parameter(child) for child in element.all('param')]

    def _parameter(self, element: Element) -> Any:
        file = element.text('from')
        if file is not None:
            return self._at(ParameterFile(
                self.parse_substitution(file),
                allow_substs=self._optional(element, 'allow_substs') or False), element)
        name = element.get_attr('name')
        inner = element.all('param')
        if inner:
            block: dict[str, Any] = {}
            for child in inner:
                block.update(self._parameter(child))
            return {name: block}
        return {name: self._value(element)}

    def _value(self, element: Element) -> Any:
        value = element.get_attr('value')
        kind = {'str': str, 'int': int, 'float': float, 'bool': bool}.get(
            element.text('type') or '')
        separator = element.text('value-sep') or element.text('value_sep')
        if separator is not None and isinstance(value, str):
            value = [part.strip() for part in value.split(separator)]
        if isinstance(value, list):
            return [self._text_value(part, kind, element) for part in value]
        return self._text_value(value, kind, element)

    def _text_value(self, value: Any, kind: Any, element: Element) -> Any:
        if not isinstance(value, str):
            return value
        parse = self.parse_if_substitutions if element.is_typed else self.parse_substitution
        return self._at(ParameterValue(parse(value), value_type=kind), element)

    # What groups give to nodes ------------------------------------------------------------------

    def _make_set_parameter(self, element: Element) -> Entity:
        return ros_node.SetParameter(element.get_attr('name'), self._value(element),
                                     condition=self.condition_of(element))

    def _make_set_use_sim_time(self, element: Element) -> Entity:
        return ros_node.SetUseSimTime(self._value(element), condition=self.condition_of(element))


def _truth(element: Element, name: str, default: bool) -> bool:
    value = element.text(name)
    return default if value is None else value.strip().lower() in ('true', '1', 'yes', 'on')


def _words(text: Any) -> list[str]:
    """Return the words of a command; brackets and quotes keep words together."""
    words: list[str] = []
    letters: list[str] = []
    depth = 0
    quote = ''
    for sign in str(text):
        if quote:
            quote = '' if sign == quote else quote
        elif sign in '\'"' and depth == 0:
            quote = sign
        depth += (sign == '(') - (sign == ')')
        if sign.isspace() and depth <= 0 and not quote:
            if letters:
                words.append(''.join(letters))
            letters = []
        else:
            letters.append(sign)
    if letters:
        words.append(''.join(letters))
    return [_unquoted(word) for word in words]


def _unquoted(word: str) -> str:
    if '$(' in word or not set(word) & set('\'"\\'):
        return word
    try:
        return ' '.join(shlex.split(word))
    except ValueError:
        return word
