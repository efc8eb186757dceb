# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes: processes, components that are loaded into a process, and settings of groups for them."""

from __future__ import annotations

from collections.abc import Iterable
import os
from typing import Any

from armsim_ros.launch.api.context import (
    Action,
    describe_text,
    LaunchContext,
    perform_text,
    SomeText,
    TextSubstitution,
)
from armsim_ros.launch.api.namespaces import make_namespace_absolute, prefix_namespace
from armsim_ros.launch.api.process import ExecuteProcess
from armsim_ros.launch.api.ros_parameters import evaluate_parameters, ParameterFile
from armsim_ros.launch.failures import LaunchError, Placed
from armsim_ros.launch.process_spec import (
    ALL_NODES,
    COMPONENTS,
    ParameterSource,
    ProcessSpec,
    RosNode,
)

#: Configurations that hold the settings of groups for the nodes inside them.
NAMESPACE_KEY = 'ros_namespace'
PARAMETERS_KEY = 'global_params'
REMAPPINGS_KEY = 'ros_remaps'


class RosExecutable:
    """A program of a package, under the name of launch_ros's descriptions."""


class Node(ExecuteProcess):
    """
    Starts a program of a package as a node.

    :param package: has the program.
    :param executable: the program.
    :param name: of the node; the program's own where None.
    :param namespace: inside that of the group, unless it begins with a slash.
    :param parameters: blocks and files; later ones win.
    :param remappings: (from, to) pairs.
    """

    UNSPECIFIED_NODE_NAME = '<node_name_unspecified>'
    UNSPECIFIED_NODE_NAMESPACE = '<node_namespace_unspecified>'

    def __init__(
        self, *, executable: SomeText | None = None, package: SomeText | None = None,
        name: SomeText | None = None, namespace: SomeText | None = None, exec_name: Any = None,
        parameters: Any = None, remappings: Any = None, ros_arguments: Any = None,
        arguments: Any = None, node_executable: SomeText | None = None,
        node_name: SomeText | None = None, node_namespace: SomeText | None = None,
        output: Any = 'log', **kwargs: Any
    ) -> None:
        """Keep all of it; the names with ``node_`` are those of Foxy and before."""
        executable = executable if executable is not None else node_executable
        if executable is None:
            raise TypeError("Node needs an 'executable'")
        kwargs.pop('autostart', None)
        super().__init__(cmd=[executable], output=output, name=exec_name, **kwargs)
        self._package, self._program = package, executable
        self._node_name = name if name is not None else node_name
        self._namespace = namespace if namespace is not None else node_namespace
        self._parameters = [] if parameters is None else parameters
        self._remappings = list(remappings or ())
        self._arguments = _as_list(arguments)
        self._ros_arguments = _as_list(ros_arguments)
        self._expanded: RosNode | None = None

    @property
    def node_package(self) -> Any:
        """The package as it was given."""
        return self._package

    @property
    def node_executable(self) -> Any:
        """The program as it was given."""
        return self._program

    @property
    def node_name(self) -> str:
        """Namespace and name, once it is started."""
        if self._expanded is None:
            return self.UNSPECIFIED_NODE_NAME
        return self._expanded.namespace.rstrip('/') + '/' + self._expanded.name

    @property
    def expanded_node_namespace(self) -> str:
        """The namespace, once it is started."""
        return (self._expanded.namespace if self._expanded is not None
                else self.UNSPECIFIED_NODE_NAMESPACE)

    def is_node_name_fully_specified(self) -> bool:
        """Return whether name and namespace are known."""
        return self._expanded is not None and self._expanded.key != ALL_NODES

    def describe(self) -> str:
        """Return a description for messages."""
        package = describe_text(self._package) if self._package is not None else "''"
        return f'Node(package={package}, executable={describe_text(self._program)})'

    def spec(self, context: LaunchContext) -> ProcessSpec:
        """Return the process with its node."""
        made = super().spec(context)
        executable = perform_text(context, self._program)
        package = perform_text(context, self._package) if self._package is not None else ''
        own = context.launch_configurations
        name = '' if self._node_name is None else perform_text(context, self._node_name)
        namespace = _namespace(context, self._namespace)
        try:
            parameters = evaluate_parameters(context, self._parameters)
        except TypeError as error:
            raise LaunchError(f'parameters of {package}/{executable}: {error}',
                                self.where) from None
        made.node = self._expanded = RosNode(
            package=package or '-',
            executable=executable,
            name=name, namespace=namespace or '/',
            parameters=[source for source in parameters if self._exists(context, source)],
            group_parameters=own.get(PARAMETERS_KEY, ()),
            key=f'{namespace.rstrip("/")}/{name}' if namespace and name else ALL_NODES,
            remappings=[*own.get(REMAPPINGS_KEY, ()), *(
                (perform_text(context, source), perform_text(context, target))
                for source, target in self._remappings)],
            arguments=[_word(context, argument) for argument in self._arguments],
            ros_arguments=[_word(context, argument) for argument in self._ros_arguments])
        if self.process_description.name is None:
            made.name = executable
        return made

    def _exists(self, context: LaunchContext, source: ParameterSource) -> bool:
        """Return whether parameters are there; warn of a file that is not."""
        if not isinstance(source, str) or os.path.isfile(source):
            return True
        if context.engine is not None:
            context.engine.log('WARNING', f'{self.where}: parameter file path is not a file: '
                               f'{source}')
        return False


class LifecycleNode(Node):
    """
    A node with a lifecycle.

    :param name: of the node.
    """

    def __init__(self, *, name: SomeText, namespace: SomeText, autostart: Any = False,
                 **kwargs: Any) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self.is_lifecycle = True


class PushRosNamespace(Action):
    """
    The nodes after it in its group are in a namespace.

    :param namespace: relative to that around it, unless it begins with a slash.
    """

    def __init__(self, namespace: SomeText, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._given = namespace

    def execute(self, context: LaunchContext) -> None:
        """Enter it."""
        context.launch_configurations[NAMESPACE_KEY] = _namespace(context, self._given)


class SetParameter(Action):
    """
    The nodes after it in its group have a parameter.

    :param name: of the parameter.
    :param value: its value; a text has the type that YAML sees in it.
    """

    def __init__(self, name: SomeText, value: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._pair = {name: TextSubstitution(text=value) if isinstance(value, str) else value}

    def execute(self, context: LaunchContext) -> None:
        """Add it."""
        _extend(context, PARAMETERS_KEY, evaluate_parameters(context, [self._pair]))


class SetParametersFromFile(Action):
    """
    The nodes after it in its group have the parameters of a file.

    :param filename: its path.
    """

    def __init__(self, filename: SomeText, node_name: SomeText | None = None, **kwargs: Any
                 ) -> None:
        super().__init__(**kwargs)
        self._file = ParameterFile(filename, allow_substs=True)

    def execute(self, context: LaunchContext) -> None:
        """Add the file."""
        _extend(context, PARAMETERS_KEY, [self._file.evaluate(context)])


class SetUseSimTime(SetParameter):
    """
    The nodes after it in its group take their time from /clock, or not.

    :param value: true or false.
    """

    def __init__(self, value: Any, **kwargs: Any) -> None:
        super().__init__('use_sim_time', value, **kwargs)


class SetRemap(Action):
    """
    The nodes after it in its group have a remapping.

    :param src: the name.
    :param dst: what it becomes.
    """

    def __init__(self, src: SomeText, dst: SomeText, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._pair = src, dst

    def execute(self, context: LaunchContext) -> None:
        """Add it."""
        source, target = (perform_text(context, part) for part in self._pair)
        _extend(context, REMAPPINGS_KEY, [(source, target)])


class SetROSLogDir(Action):
    """
    Logs go into a folder.

    :param new_log_dir: the folder.
    """

    def __init__(self, new_log_dir: SomeText, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._folder = new_log_dir

    def execute(self, context: LaunchContext) -> None:
        """Set it."""
        context.environment['ROS_LOG_DIR'] = perform_text(context, self._folder)


def _namespace(context: LaunchContext, given: SomeText | None) -> str | None:
    """Return a namespace inside that of the group, None where neither has one."""
    return make_namespace_absolute(prefix_namespace(
        context.launch_configurations.get(NAMESPACE_KEY),
        None if given is None else perform_text(context, given)))


def _extend(context: LaunchContext, key: str, values: Iterable[Any]) -> None:
    """Add to a list of the scope; that of the scope around it stays as it is."""
    own = context.launch_configurations
    own[key] = [*own.get(key, ()), *values]


def _as_list(values: Any) -> list[Any]:
    if values is None:
        return []
    return [values] if isinstance(values, str) else list(values)


def _word(context: LaunchContext, value: Any) -> str:
    return str(value) if isinstance(value, (bool, int, float)) else perform_text(context, value)


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
        node_name: Any = None
    ) -> None:
        self.package, self.node_plugin = package, plugin
        self.node_name = name if name is not None else node_name
        self.node_namespace = namespace
        self.parameters, self.remappings = parameters, list(remappings or ())
        self.extra_arguments, self.condition = extra_arguments, condition

    def node(self, context: LaunchContext) -> RosNode | None:
        """Return it with all substitutions performed, None if its condition does not hold."""
        if self.condition is not None and not self.condition.evaluate(context):
            return None
        return RosNode(
            package=perform_text(context, self.package),
            executable=perform_text(context, self.node_plugin),
            name=perform_text(context, self.node_name) if self.node_name is not None else '',
            namespace=_namespace(context, self.node_namespace) or '/',
            parameters=evaluate_parameters(context, self.parameters),
            remappings=[(perform_text(context, source), perform_text(context, target))
                        for source, target in self.remappings])


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
        self, *, composable_node_descriptions: Iterable[Any], target_container: Any, **kwargs: Any,
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._nodes = list(composable_node_descriptions)

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
                # The container is not started either.
                context.engine.tell_unknown(
                    f'{node.package}/{node.executable} is not installed and not started')


class ComposableNodeContainer(Node):
    """
    A process that loads components.

    :param composable_node_descriptions: loaded at its start.
    """

    def __init__(
        self, *, name: SomeText, namespace: SomeText | None = None,
        composable_node_descriptions: Iterable[Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self._components = list(composable_node_descriptions or ())

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
