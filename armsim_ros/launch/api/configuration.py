# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments, configurations, environment variables, and the conditions that read them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, MutableMapping
import os
from typing import Any

from armsim_ros.launch.api.context import (
    Action,
    describe_text,
    LaunchContext,
    LaunchDescriptionEntity,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
    SomeText,
    to_bool,
)
from armsim_ros.launch.failures import LaunchError, MissingArgumentsError, Placed


class DeclareLaunchArgument(Action):
    """
    An argument of a launch file.

    :param name: of the argument.
    :param default_value: if None, it has to be given.
    :param choices: the values that it may have; of a text, its parts, as ``in`` does.
    """

    def __init__(
        self, name: str, *, default_value: Any = None, description: str | None = None,
        choices: Iterable[str] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(condition=kwargs.pop('condition', None))
        kwargs.clear()
        self.name = str(name)
        if isinstance(default_value, (bool, int, float)):
            # launch refuses these; their meaning is plain.
            default_value = str(default_value)
        self.default_value = (None if default_value is None
                              else normalize_to_list_of_substitutions(default_value))
        self.description = description or 'no description given'
        self.choices = choices if choices is None or isinstance(choices, str) else [
            str(choice) for choice in choices]

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type, dict[str, Any]]:
        """Read an ``<arg>``."""
        _, kwargs = super().parse(entity, parser)
        kwargs['name'] = parser.escape_characters(entity.get_attr('name'))
        default = entity.get_attr('default', optional=True)
        if default is not None:
            kwargs['default_value'] = parser.parse_substitution(default)
        kwargs['description'] = entity.get_attr('description', optional=True)
        choices = entity.get_attr('choice', data_type=list, optional=True)
        if choices:
            kwargs['choices'] = [choice.get_attr('value') for choice in choices]
        return cls, kwargs

    def describe(self) -> str:
        """Return a description for messages."""
        return f"DeclareLaunchArgument('{self.name}')"

    def execute(self, context: LaunchContext) -> None:
        """Set the default where it was not given, and check the choices."""
        values = context.launch_configurations
        if self.name not in values:
            if self.default_value is None:
                raise MissingArgumentsError([(self.name, self._listed_choices())])
            values[self.name] = perform_substitutions(context, self.default_value)
        if self.choices is not None and values[self.name] not in self.choices:
            raise LaunchError(f"argument '{self.name}' is '{values[self.name]}'; allowed: "
                                f"{', '.join(self._listed_choices())}", self.where)

    def _listed_choices(self) -> list[str]:
        """Return the choices for messages."""
        return [self.choices] if isinstance(self.choices, str) else self.choices or []


class _SetAction(Action):
    """Sets a named value."""

    def __init__(self, name: SomeText, value: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._name = normalize_to_list_of_substitutions(name)
        self._value = normalize_to_list_of_substitutions(
            str(value) if isinstance(value, (bool, int, float)) else value)

    def execute(self, context: LaunchContext) -> None:
        """Set it."""
        name = perform_substitutions(context, self._name)
        self._values(context)[name] = perform_substitutions(context, self._value)

    def describe(self) -> str:
        """Return a description for messages."""
        return f'{type(self).__name__}({describe_text(self._name)})'

    @staticmethod
    def _values(context: LaunchContext) -> MutableMapping[str, str]:
        """Return the dictionary that holds the value."""
        raise NotImplementedError


class SetLaunchConfiguration(_SetAction):
    """Sets a configuration."""

    @staticmethod
    def _values(context: LaunchContext) -> dict[str, str]:
        return context.launch_configurations


class UnsetLaunchConfiguration(Action):
    """Removes a configuration."""

    def __init__(self, name: SomeText, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._name = name

    def execute(self, context: LaunchContext) -> None:
        """Remove it."""
        context.launch_configurations.pop(perform_text(context, self._name), None)


class ResetLaunchConfigurations(Action):
    """
    Removes all configurations.

    :param launch_configurations: those that there are then.
    """

    def __init__(self, launch_configurations: dict[Any, Any] | None = None, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._kept = dict(launch_configurations or {})

    def execute(self, context: LaunchContext) -> None:
        """Remove all others."""
        kept = {perform_text(context, name): perform_text(context, value)
                for name, value in self._kept.items()}
        context.launch_configurations.clear()
        context.launch_configurations.update(kept)


class PushLaunchConfigurations(Action):
    """Begins a scope of configurations."""

    def execute(self, context: LaunchContext) -> None:
        """Begin it."""
        context.push_launch_configurations()


class PopLaunchConfigurations(Action):
    """Ends a scope of configurations."""

    def execute(self, context: LaunchContext) -> None:
        """End it."""
        context.pop_launch_configurations()


class PushEnvironment(Action):
    """Begins a scope of the environment."""

    def execute(self, context: LaunchContext) -> None:
        """Begin it."""
        context.push_environment()


class PopEnvironment(Action):
    """Ends a scope of the environment."""

    def execute(self, context: LaunchContext) -> None:
        """End it."""
        context.pop_environment()


class ResetEnvironment(Action):
    """Restores the environment that the launch began with."""

    def execute(self, context: LaunchContext) -> None:
        """Reset it."""
        context.reset_environment()


class SetEnvironmentVariable(_SetAction):
    """Sets an environment variable of the processes."""

    @staticmethod
    def _values(context: LaunchContext) -> MutableMapping[str, str]:
        return context.environment


class UnsetEnvironmentVariable(Action):
    """Removes an environment variable of the processes."""

    def __init__(self, name: SomeText, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._name = name

    def execute(self, context: LaunchContext) -> None:
        """Remove it."""
        context.environment.pop(perform_text(context, self._name), None)


class AppendEnvironmentVariable(Action):
    """
    Appends to an environment variable of the processes.

    :param name: of the variable.
    :param value: what is added.
    :param prepend: whether at the front.
    :param separator: between the old value and the new value.
    """

    def __init__(
        self, name: SomeText, value: SomeText, prepend: Any = False,
        separator: SomeText = os.pathsep, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._name, self._value = name, value
        self._prepend, self._separator = prepend, separator

    def execute(self, context: LaunchContext) -> None:
        """Add it."""
        name = perform_text(context, self._name)
        value = perform_text(context, self._value)
        old = context.environment.get(name, '')
        front = self._prepend if isinstance(self._prepend, bool) else (
            perform_text(context, self._prepend).lower() == 'true')
        words = [value, old] if front else [old, value]
        separator = perform_text(context, self._separator)
        context.environment[name] = separator.join(word for word in words if word)


def declared_arguments(
    entities: Iterable[LaunchDescriptionEntity], *, conditional: bool = True,
) -> list[DeclareLaunchArgument]:
    """
    Return the arguments that a description declares, without those of includes.

    :param conditional: whether those that a condition or an event decides about are included.
    """
    found: list[DeclareLaunchArgument] = []
    for entity in entities:
        if isinstance(entity, DeclareLaunchArgument) and (conditional or entity.condition is None):
            found.append(entity)
        found += declared_arguments(entity.describe_sub_entities(), conditional=conditional)
        for _, inside in entity.describe_conditional_sub_entities() if conditional else ():
            found += declared_arguments(inside)
    return found


class InvalidConditionExpressionError(LaunchError):
    """A condition is neither true nor false."""


class Condition(Placed):
    """
    A predicate over the context.

    :param predicate: returns whether the condition holds.
    """

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether it holds."""
        return self._predicate is None or bool(self._predicate(context))

    def _predicate_func(self, context: LaunchContext) -> bool:
        """Return whether it holds; some launch files call this private name of upstream."""
        return self.evaluate(context)

    def describe(self) -> str:
        """Return a description for messages."""
        return type(self).__name__


def evaluate_condition_expression(context: LaunchContext, expression: SomeText) -> bool:
    """
    Return the truth of a text.

    :raises InvalidConditionExpressionError: where it is neither true, false, 1 nor 0.
    """
    try:
        return to_bool(perform_text(context, expression), 'a condition')
    except LaunchError as failure:
        raise InvalidConditionExpressionError(failure.what, failure.where) from None


class IfCondition(Condition):
    """
    Holds if a text is true.

    :param predicate_expression: gives true, false, 1 or 0.
    """

    def __init__(self, predicate_expression: SomeText | Any) -> None:
        super().__init__()
        self._expression = predicate_expression
        describe_text(predicate_expression)

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the text is true."""
        try:
            return evaluate_condition_expression(context, self._expression)
        except LaunchError as failure:
            raise failure.at(self.where) from None

    def describe(self) -> str:
        """Return a description for messages."""
        return f'{type(self).__name__}({describe_text(self._expression)})'


class UnlessCondition(IfCondition):
    """Holds if a text is false."""

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the text is false."""
        return not super().evaluate(context)


class LaunchConfigurationEquals(Condition):
    """
    Holds if a configuration has a given value.

    :param launch_configuration_name: of the configuration.
    :param expected_value: None for: it is not set.
    """

    def __init__(self, launch_configuration_name: str, expected_value: SomeText | None) -> None:
        super().__init__()
        self._name, self._expected = launch_configuration_name, expected_value

    def evaluate(self, context: LaunchContext) -> bool:
        """Compare."""
        value = context.launch_configurations.get(self._name)
        if self._expected is None or value is None:
            return self._expected is None and value is None
        return bool(value == perform_text(context, self._expected))


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """Holds if a configuration does not have a given value."""

    def evaluate(self, context: LaunchContext) -> bool:
        """Compare."""
        return not super().evaluate(context)
