# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Event handlers, and actions that register them, wait, emit events or end the launch."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from armsim_ros.launch.api import events
from armsim_ros.launch.api.context import (
    Action,
    LaunchContext,
    LaunchDescriptionEntity,
    normalize_to_list_of_entities,
    perform_text,
    SomeText,
)
from armsim_ros.launch.failures import LaunchError


class EventHandler:
    """
    Returns entities for each event that it matches.

    :param matcher: whether an event matches.
    :param entities: what is visited then.
    :param handle_once: whether only the first counts.
    """

    def __init__(
        self, *, matcher: Callable[[Any], bool], entities: Any = None, handle_once: bool = False,
    ) -> None:
        self._matcher, self._entities, self.handle_once = matcher, entities, handle_once

    def matches(self, event: Any) -> bool:
        """Return whether the handler is for the event."""
        return bool(self._matcher(event))

    def handle(self, event: Any, context: LaunchContext) -> Iterable[Any] | None:
        """Return the entities to visit."""
        if self.handle_once:
            context.unregister_event_handler(self)
        context.extend_locals({'event': event})
        return _result(self._entities, event, context)

    def actions_described(self) -> list[LaunchDescriptionEntity]:
        """Return the entities that may be visited, as far as they are known in advance."""
        if self._entities is None or _is_function(self._entities):
            return []
        return normalize_to_list_of_entities([self._entities])


class BaseEventHandler(EventHandler):
    """The same under its older name."""


class _OfTarget(EventHandler):
    """Waits for an event of an action, of several, of those a function chooses, or of any."""

    def __init__(self, kind: type, target: Any, then: Any, handle_once: bool) -> None:
        super().__init__(matcher=lambda event: isinstance(event, kind) and self._is_target(event),
                         entities=then, handle_once=handle_once)
        self.target_action = target

    def _is_target(self, event: Any) -> bool:
        target = self.target_action
        if target is None:
            return True
        if isinstance(target, (list, tuple)):
            return any(event.action is action for action in target)
        if isinstance(target, LaunchDescriptionEntity):
            return event.action is target
        return bool(target(event.action))


class OnProcessStart(_OfTarget):
    """
    Waits for the start of a process.

    :param on_start: entities, or a function of event and context.
    """

    def __init__(self, *, target_action: Any = None, on_start: Any = None,
                 handle_once: bool = False, **_kwargs: Any) -> None:
        super().__init__(events.ProcessStarted, target_action, on_start, handle_once)


class OnProcessExit(_OfTarget):
    """
    Waits for the end of a process.

    :param on_exit: entities, or a function of event and context.
    """

    def __init__(self, *, target_action: Any = None, on_exit: Any = None,
                 handle_once: bool = False, **_kwargs: Any) -> None:
        super().__init__(events.ProcessExited, target_action, on_exit, handle_once)


class OnExecutionComplete(_OfTarget):
    """
    Waits for the end of an action.

    :param on_completion: entities, or a function of event and context.
    """

    def __init__(self, *, target_action: Any = None, on_completion: Any = None,
                 handle_once: bool = False, **_kwargs: Any) -> None:
        super().__init__(events.ExecutionComplete, target_action, on_completion, handle_once)


class OnStateTransition(_OfTarget):
    """
    Waits for a change of a lifecycle node's state.

    :param target_lifecycle_node: the node.
    :param entities: what is visited then.
    """

    def __init__(
        self, *, entities: Any = None, target_lifecycle_node: Any = None,
        transition: str | None = None, start_state: str | None = None,
        goal_state: str | None = None, matcher: Any = None, handle_once: bool = False,
        **_kwargs: Any
    ) -> None:
        super().__init__(events.StateTransition, target_lifecycle_node, entities, handle_once)
        self._states = (start_state, goal_state)
        self.transition, self._own_matcher = transition, matcher

    def _is_target(self, event: Any) -> bool:
        if self._own_matcher is not None:
            return bool(self._own_matcher(event))
        start, goal = self._states
        return (super()._is_target(event) and start in (None, event.start_state)
                and goal in (None, event.goal_state))


class OnShutdown(EventHandler):
    """
    Waits for the end of the launch.

    :param on_shutdown: entities, or a function of event and context.
    """

    def __init__(self, *, on_shutdown: Any, **kwargs: Any) -> None:
        super().__init__(matcher=lambda event: isinstance(event, events.Shutdown),
                         entities=on_shutdown, handle_once=kwargs.get('handle_once', False))


class OnIncludeLaunchDescription(EventHandler):
    """Executes the launch description that such an event brings; every launch has this handler."""

    def __init__(self, **_kwargs: Any) -> None:
        super().__init__(matcher=lambda event: isinstance(event, events.IncludeLaunchDescription),
                         entities=lambda event, context: [event.launch_description])


class OnProcessIO(_OfTarget):
    """
    Waits for the output of processes.

    :param on_stdout: a function of the event.
    :param on_stderr: a function of the event.
    """

    def __init__(self, *, target_action: Any = None, on_stdin: Any = None, on_stdout: Any = None,
                 on_stderr: Any = None, handle_once: bool = False, **_kwargs: Any) -> None:
        super().__init__(events.ProcessIO, target_action, None, handle_once)
        self._functions = {1: on_stdout, 2: on_stderr}

    def handle(self, event: Any, context: LaunchContext) -> Iterable[Any] | None:
        """Call the function for the stream."""
        function = self._functions.get(event.fd)
        if function is None:
            return None
        if self.handle_once:
            context.unregister_event_handler(self)
        result: Iterable[Any] | None = function(event)
        return result


def _result(entities: Any, event: Any, context: LaunchContext) -> Iterable[Any] | None:
    if _is_function(entities):
        entities = entities(event, context)
    if entities is None:
        return None
    return normalize_to_list_of_entities([entities])


def _is_function(value: Any) -> bool:
    return callable(value) and not isinstance(value, LaunchDescriptionEntity)


Entities = list[LaunchDescriptionEntity]


class TimerAction(Action):
    """
    Actions that are executed after a delay.

    :param period: [s].
    :param actions: what is done then.
    """

    def __init__(
        self, *, period: Any, actions: Iterable[Any], cancel_on_shutdown: Any = True, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self.period = period
        self._actions = normalize_to_list_of_entities(actions)
        self._cancelled = False

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the actions."""
        return [('a time has passed', self._actions)]

    @property
    def actions(self) -> Entities:
        """The delayed actions."""
        return self._actions

    def cancel(self) -> None:
        """Cancel the timer."""
        self._cancelled = True

    def execute(self, context: LaunchContext) -> None:
        """Start the timer."""
        period = self.period
        if not isinstance(period, (int, float)):
            text = perform_text(context, period)
            try:
                period = float(text)
            except ValueError:
                raise LaunchError(f"the period of a TimerAction is '{text}'; allowed: a number "
                                    'of seconds', self.where) from None
        if context.engine is not None:
            context.engine.call_later(self, float(period), self._due)

    def _due(self) -> Entities:
        return [] if self._cancelled else self._actions


class RegisterEventHandler(Action):
    """
    Registers an event handler.

    :param event_handler: the handler.
    """

    def __init__(self, event_handler: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._handler = event_handler

    @property
    def event_handler(self) -> Any:
        """The handler."""
        return self._handler

    def execute(self, context: LaunchContext) -> None:
        """Register it."""
        context.register_event_handler(self._handler)

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the actions that the handler may return."""
        describe = getattr(self._handler, 'actions_described', None)
        return [('an event', describe())] if describe is not None else []


class UnregisterEventHandler(Action):
    """
    Unregisters an event handler.

    :param event_handler: the handler.
    """

    def __init__(self, event_handler: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._handler = event_handler

    def execute(self, context: LaunchContext) -> None:
        """Unregister it."""
        context.unregister_event_handler(self._handler)


class EmitEvent(Action):
    """
    Emits an event.

    :param event: the event.
    """

    def __init__(self, *, event: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.event = event

    def execute(self, context: LaunchContext) -> None:
        """Queue the event."""
        context.emit_event_sync(self.event)


class Shutdown(EmitEvent):
    """
    Ends the launch.

    :param reason: for the log.
    """

    def __init__(self, *, reason: SomeText = 'reason not given', **kwargs: Any) -> None:
        super().__init__(event=None, **kwargs)
        self._reason = reason

    def execute(self, context: LaunchContext) -> None:
        """Queue the end; after a process that failed, with its failure."""
        failed = context.get_locals_as_dict().get('event')
        status = getattr(failed, 'returncode', None)
        context.emit_event_sync(events.Shutdown(
            reason=perform_text(context, self._reason),
            due_to_failure=bool(status) and not context.is_shutdown))


class RosTimer(TimerAction):
    """Actions after a delay; simulated time is taken to run as fast as the wall clock."""


class LifecycleTransition(Action):
    """
    Requests transitions of lifecycle nodes.

    :param lifecycle_node_names: the nodes.
    :param transition_ids: the transitions in order.
    """

    def __init__(
        self, *, lifecycle_node_names: Iterable[Any], transition_ids: Iterable[Any], **kwargs: Any,
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._names = list(lifecycle_node_names)
        self._transitions = list(transition_ids)

    def execute(self, context: LaunchContext) -> None:
        """Log that nothing is done: none of our programs is a lifecycle node."""
        if context.engine is not None:
            context.engine.tell_unknown('transitions of lifecycle nodes are not requested')
