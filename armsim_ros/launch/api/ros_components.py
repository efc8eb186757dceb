# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Components: nodes that are loaded into a container process."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from armsim_ros.launch.api.context import Action, LaunchContext, Placed, SomeText
from armsim_ros.launch.api.ros_node import make_namespace, NAMESPACE_KEY, Node
from armsim_ros.launch.api.ros_parameters import evaluate_parameters
from armsim_ros.launch.api.utilities import perform_text
from armsim_ros.launch.process_spec import COMPONENTS, ProcessSpec, RosNode


class ComposableNode(Placed):
    """
    A node in a library.

    :param package: has the library.
    :param plugin: the node's class.
    """

    def __init__(
        self, *, package: SomeText, plugin: SomeText, name: SomeText | None = None,
        namespace: SomeText | None = None, parameters: Any = None, remappings: Any = None,
        extra_arguments: Any = None, condition: Any = None, node_plugin: Any = None,
        node_name: Any = None,
    ) -> None:
        self.package, self.node_plugin = package, plugin
        self.node_name = name if name is not None else node_name
        self.node_namespace = namespace
        self.parameters, self.remappings = parameters, list(remappings or ())
        self.extra_arguments = extra_arguments
        self.condition = condition

    def node(self, context: LaunchContext) -> RosNode | None:
        """Return it with all substitutions performed, None if its condition does not hold."""
        if self.condition is not None and not self.condition.evaluate(context):
            return None
        own = context.launch_configurations
        return RosNode(
            package=perform_text(context, self.package),
            executable=perform_text(context, self.node_plugin),
            name=perform_text(context, self.node_name) if self.node_name is not None else '',
            namespace=make_namespace(
                own.get(NAMESPACE_KEY, ''), perform_text(context, self.node_namespace)
                if self.node_namespace is not None else ''),
            parameters=evaluate_parameters(context, self.parameters),
            remappings=[(perform_text(context, source), perform_text(context, target))
                        for source, target in self.remappings],
        )


    def process(self, package: str, executable: str) -> Node:
        """Return a program that does the component's work in a process of its own."""
        return Node(package=package, executable=executable, name=self.node_name,
                    namespace=self.node_namespace, parameters=self.parameters,
                    remappings=self.remappings, output='screen')


class ComposableLifecycleNode(ComposableNode):
    """A component with a lifecycle."""


class LoadComposableNodes(Action):
    """
    Loads components into a running container.

    :param target_container: the container, or its name.
    :param composable_node_descriptions: the components.
    """

    def __init__(
        self, *, composable_node_descriptions: Iterable[Any], target_container: Any,
        **kwargs: Any,
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._nodes = list(composable_node_descriptions)
        self._target = target_container

    def execute(self, context: LaunchContext) -> None:
        """Have the engine load each component."""
        if context.engine is None:
            return
        for component in _flat(self._nodes):
            node = component.node(context)
            if node is None:
                continue
            if node.executable in COMPONENTS:
                context.engine.visit(component.process(*COMPONENTS[node.executable]))
            else:
                context.engine.load_component(node, self._container(context))

    def _container(self, context: LaunchContext) -> str:
        if isinstance(self._target, Node):
            return self._target.node_name
        name = perform_text(context, self._target)
        return make_namespace(context.launch_configurations.get(NAMESPACE_KEY, ''), name)


class ComposableNodeContainer(Node):
    """
    A process that loads components.

    :param composable_node_descriptions: loaded at its start.
    """

    def __init__(
        self, *, name: SomeText, namespace: SomeText | None = None,
        composable_node_descriptions: Iterable[Any] | None = None, **kwargs: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self._components = list(composable_node_descriptions or ())

    def spec(self, context: LaunchContext) -> ProcessSpec:
        """Return the process."""
        return super().spec(context)

    def execute(self, context: LaunchContext) -> None:
        """Start it, and load the components."""
        super().execute(context)
        if self._components:
            LoadComposableNodes(composable_node_descriptions=self._components,
                                target_container=self).execute(context)


def _flat(nodes: Iterable[Any]) -> list[Any]:
    found: list[Any] = []
    for item in nodes:
        found += _flat(item) if isinstance(item, (list, tuple)) else [item]
    return [item for item in found if item is not None]


