# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch descriptions: what a launch file returns, and includes of launch files in others."""

from __future__ import annotations

from collections.abc import Iterable
import os
from pathlib import Path
from typing import Any

from armsim_ros.launch.api.configuration import (
    declared_arguments,
    DeclareLaunchArgument,
    SetLaunchConfiguration,
)
from armsim_ros.launch.api.context import (
    Action,
    describe_text,
    LaunchContext,
    LaunchDescriptionEntity,
    normalize_to_list_of_entities,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
    SomeText,
)
from armsim_ros.launch.failures import LaunchError, MissingArgumentsError, Placed, StoppedError
from armsim_ros.launch.lookup import check_not_missing, stand_in_of


class LaunchDescription(LaunchDescriptionEntity):
    """
    Entities that are visited in order.

    :param initial_entities: the first of them.
    """

    def __init__(
        self, initial_entities: Iterable[Any] | None = None, *,
        deprecated_reason: str | None = None
    ) -> None:
        self._entities = normalize_to_list_of_entities(initial_entities or ())
        self.deprecated_reason = deprecated_reason

    @property
    def entities(self) -> list[LaunchDescriptionEntity]:
        """What is visited."""
        return self._entities

    @property
    def deprecated(self) -> bool:
        """Whether its file should no longer be used."""
        return self.deprecated_reason is not None

    def add_entity(self, entity: Any) -> None:
        """Add an entity at the end."""
        self._entities += normalize_to_list_of_entities([entity])

    def add_action(self, action: Any) -> None:
        """Add an action at the end."""
        self.add_entity(action)

    def visit(self, context: LaunchContext) -> Iterable[LaunchDescriptionEntity]:
        """Return the entities."""
        if self.deprecated_reason and context.engine is not None:
            context.engine.log('WARNING', f'deprecated launch file: {self.deprecated_reason}')
        return self._entities

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities."""
        return self._entities

    def get_launch_arguments(self, conditional_inclusion: bool = False
                             ) -> list[DeclareLaunchArgument]:
        """Return the arguments that it declares, without those of includes."""
        return declared_arguments(self._entities)


class LaunchService:
    """
    Replaces launch's service; ``armsim launch`` itself runs the descriptions.

    :param argv: the words of the command line.
    """

    def __init__(self, *, argv: Iterable[str] | None = None, **_kwargs: Any) -> None:
        self.context = LaunchContext(argv=argv)
        self._descriptions: list[LaunchDescription] = []

    def include_launch_description(self, launch_description: Any) -> None:
        """Remember a description."""
        self._descriptions.append(launch_description)

    def run(self, **_kwargs: Any) -> int:
        """Refuse: the launch that evaluates this file is running."""
        raise LaunchError('a launch file cannot run a LaunchService of its own; return the '
                            'description from generate_launch_description()')

    def shutdown(self) -> None:
        """Do nothing: nothing runs."""


class LaunchIntrospector:
    """Shows what is in a description."""

    def format_launch_description(self, launch_description: LaunchDescription) -> str:
        """Return it as a tree of lines."""
        return '\n'.join(format_entities(launch_description.entities))

    def get_launch_description(self) -> None:
        """Return None: nothing is read."""


def format_entities(entities: Iterable[LaunchDescriptionEntity], indent: str = '') -> list[str]:
    """Return entities and those inside them as a tree of lines."""
    lines: list[str] = []
    for entity in entities:
        lines.append(f'{indent}{entity.describe()}')
        lines += format_entities(entity.describe_sub_entities(), indent + '  ')
        for when, inside in entity.describe_conditional_sub_entities():
            lines.append(f'{indent}  if {when}:')
            lines += format_entities(normalize_to_list_of_entities(inside), indent + '    ')
    return lines


#: How deep includes may be nested, and how often a file may include itself on the way.
DEEPEST_INCLUDE = 40
MOST_REPEATS = 8


class LaunchDescriptionSource(Placed):
    """
    The source of a launch description.

    :param launch_description: the description, where it is there already.
    :param location: of the file.
    """

    def __init__(
        self, launch_description: LaunchDescription | None = None,
        location: SomeText | None = None, method: str = 'unspecified mechanism from a script',
    ) -> None:
        self._description = launch_description
        self._location = None if location is None else normalize_to_list_of_substitutions(location)
        self._method = method

    @property
    def location(self) -> str:
        """The location, for messages."""
        return '' if self._location is None else describe_text(self._location)

    def path(self, context: LaunchContext) -> str:
        """Return the path of the file, '' if there is none."""
        return '' if self._location is None else perform_substitutions(context, self._location)

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """
        Return the description; its file is read now.

        :raises LaunchError: where there is no such file, or it is not a launch file.
        """
        if self._description is not None:
            return self._description
        from armsim_ros.launch.files import read_launch_file

        path = Path(self.path(context))
        if not path.is_file():
            path = stand_in_of(path) or path
        if not path.is_file():
            check_not_missing(path)
            raise LaunchError(f"launch file '{path}' does not exist", self.where)
        return read_launch_file(path)


class PythonLaunchDescriptionSource(LaunchDescriptionSource):
    """
    A Python file.

    :param launch_file_path: its path.
    """

    def __init__(self, launch_file_path: SomeText) -> None:
        super().__init__(None, launch_file_path, 'interpreted python launch file')


class AnyLaunchDescriptionSource(PythonLaunchDescriptionSource):
    """A file of any kind."""


class FrontendLaunchDescriptionSource(PythonLaunchDescriptionSource):
    """A file in XML or YAML."""

    def __init__(self, launch_file_path: SomeText, **_kwargs: Any) -> None:
        super().__init__(launch_file_path)


class XMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A file in XML."""


class YAMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A file in YAML."""


class IncludeLaunchDescription(Action):
    """
    Includes a launch file; its arguments are not scoped.

    :param launch_description_source: the file, a source or a path.
    :param launch_arguments: (name, value) pairs, or a mapping.
    """

    def __init__(
        self, launch_description_source: Any = None, *, launch_arguments: Any = None, **kwargs: Any
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        source = launch_description_source
        if isinstance(source, LaunchDescription):
            source = LaunchDescriptionSource(source)
        elif not isinstance(source, LaunchDescriptionSource):
            source = AnyLaunchDescriptionSource(source)
        self._source: LaunchDescriptionSource = source
        pairs = launch_arguments.items() if hasattr(launch_arguments, 'items') \
            else launch_arguments or ()
        self._arguments = [(name, value) for name, value in pairs]

    @property
    def launch_description_source(self) -> LaunchDescriptionSource:
        """The source of the description."""
        return self._source

    @property
    def launch_arguments(self) -> list[tuple[Any, Any]]:
        """The arguments that are given."""
        return self._arguments

    def describe(self) -> str:
        """Return a description for messages."""
        return f'IncludeLaunchDescription({self._source.location})'

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Return the file's entities, between EnterFile and LeaveFile."""
        values: list[LaunchDescriptionEntity] = []
        given: list[str] = []
        for name, value in self._arguments:
            word = perform_text(context, name)
            given.append(word)
            values.append(self._setting(word, value))
        path = self._source.path(context)
        try:
            description = self._source.get_launch_description(context)
        except LaunchError as failure:
            raise failure.at(self.where) from None
        if path:
            check_depth(context, path)
        missing = [(argument.name, argument.choices or ()) for argument in declared_arguments(
            description.entities, conditional=False) if argument.default_value is None
            and argument.name not in given and argument.name not in context.launch_configurations]
        if missing:
            raise MissingArgumentsError(list(dict.fromkeys(
                (name, tuple(choices)) for name, choices in missing)))
        if not path:
            return [*values, description]
        return [*values, EnterFile(path), description, LeaveFile()]

    def _setting(self, name: str, value: Any) -> SetLaunchConfiguration:
        try:
            return SetLaunchConfiguration(name, value)
        except TypeError as error:
            raise LaunchError(f"launch argument '{name}': {error}", self.where) from None


class EnterFile(Action):
    """
    Begins the entities of an included launch file.

    :param path: of the file.
    """

    def __init__(self, path: str) -> None:
        super().__init__()
        self._path = os.path.abspath(path)

    def execute(self, context: LaunchContext) -> None:
        """Begin its scope."""
        chain = context.get_locals_as_dict().get('launch_file_chain', ())
        context.push_locals()
        context.extend_locals({
            'current_launch_file_path': self._path,
            'current_launch_file_directory': os.path.dirname(self._path),
            'launch_file_chain': (*chain, self._path),
        })


class LeaveFile(Action):
    """Ends the entities of an included launch file."""

    def execute(self, context: LaunchContext) -> None:
        """End the scope."""
        context.pop_locals()


def check_depth(context: LaunchContext, path: str) -> None:
    """
    Stop recursive includes.

    :raises StoppedError: with the chain of files.
    """
    chain = [*context.get_locals_as_dict().get('launch_file_chain', ()), os.path.abspath(path)]
    if len(chain) > DEEPEST_INCLUDE or chain.count(chain[-1]) > MOST_REPEATS:
        files = ' -> '.join(dict.fromkeys(chain))
        raise StoppedError(f'{chain[-1]}: the launch file includes itself again and again '
                           f'({files} -> {os.path.basename(chain[-1])})')


def load_python_launch_file_as_module(path: str) -> Any:
    """Return a Python launch file as a module."""
    from armsim_ros.launch.files import load_python_file

    return load_python_file(Path(path))


def get_launch_description_from_python_launch_file(path: str) -> LaunchDescription:
    """Return the description of a Python launch file."""
    from armsim_ros.launch.files import read_launch_file

    return read_launch_file(Path(path))
