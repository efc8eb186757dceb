# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that wait for events or time, emit events, or end the launch."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from armsim_ros.launch.api.context import Action, LaunchContext, LaunchDescriptionEntity, SomeText
from armsim_ros.launch.api.events import Shutdown as ShutdownEvent
from armsim_ros.launch.api.utilities import (
    normalize_to_list_of_entities,
    perform_text,
)
from armsim_ros.launch.failures import LaunchError

Entities = list[LaunchDescriptionEntity]


class TimerAction(Action):
    """
    Actions that are executed after a delay.

    :param period: [s].
    :param actions: what is done then.
    """

    def __init__(
        self, *, period: Any, actions: Iterable[Any], cancel_on_shutdown: Any = True,
        **kwargs: Any,
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
            context.engine.call_later(float(period), self._due)

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
        context.emit_event_sync(ShutdownEvent(
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
        self, *, lifecycle_node_names: Iterable[Any], transition_ids: Iterable[Any],
        **kwargs: Any,
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._names = list(lifecycle_node_names)
        self._transitions = list(transition_ids)

    def execute(self, context: LaunchContext) -> None:
        """Log that nothing is done: none of our programs is a lifecycle node."""
        if context.engine is not None:
            context.engine.tell_unknown('transitions of lifecycle nodes are not requested')
