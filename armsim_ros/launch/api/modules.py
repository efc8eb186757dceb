# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which names of this package replace which names of upstream's modules.

A function per distribution, called when a launch file imports from it; most need two of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import re
from typing import Any

#: Module of upstream -> name in it -> object of this package.
Table = dict[str, dict[str, Any]]


def _named(*objects: Any, **renamed: Any) -> dict[str, Any]:
    """Return objects by their own names, and others by upstream's."""
    return {**{each.__name__: each for each in objects}, **renamed}


def module_of(name: str) -> str:
    """Return the name of the module that upstream has for a class."""
    return re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', name).lower()


def _launch() -> Table:
    from armsim_ros.launch import failures, files, parser, syntax
    from armsim_ros.launch.api import (
        actions,
        configuration,
        context,
        description,
        event_handlers,
        events,
        paths,
        process,
        programs,
        substitutions,
        utilities,
    )

    classes = _named(
        description.LaunchDescription, context.LaunchContext, context.LaunchDescriptionEntity,
        context.Action, context.Substitution, configuration.Condition, events.Event,
        event_handlers.EventHandler, description.LaunchDescriptionSource,
        description.LaunchService, description.LaunchIntrospector)
    texts = _named(SomeSubstitutionsType=context.SomeText,
                   SomeSubstitutionsType_types_tuple=(str, context.Substitution, Iterable))
    booleans = _named(
        substitutions.AndSubstitution, substitutions.OrSubstitution,
        substitutions.NotSubstitution, substitutions.AllSubstitution,
        substitutions.AnySubstitution)
    return {
        'launch': {**classes, **texts},
        **{f'launch.{module_of(name)}': {name: kind} for name, kind in classes.items()},
        'launch.event_handler': _named(
            event_handlers.EventHandler, event_handlers.BaseEventHandler),
        'launch.some_substitutions_type': texts,
        'launch.some_entities_type': _named(SomeEntitiesType=context.LaunchDescriptionEntity),
        'launch.some_actions_type': _named(SomeActionsType=context.LaunchDescriptionEntity),
        'launch.actions': _named(
            actions.GroupAction, actions.OpaqueFunction, actions.OpaqueCoroutine, actions.LogInfo,
            actions.Log, actions.LogDebug, actions.LogWarning, actions.LogError,
            event_handlers.TimerAction, event_handlers.RegisterEventHandler,
            event_handlers.UnregisterEventHandler, event_handlers.EmitEvent,
            event_handlers.Shutdown, actions.ForLoop, actions.ForEach,
            configuration.DeclareLaunchArgument, configuration.SetLaunchConfiguration,
            configuration.UnsetLaunchConfiguration, configuration.ResetLaunchConfigurations,
            configuration.PushLaunchConfigurations, configuration.PopLaunchConfigurations,
            configuration.PushEnvironment, configuration.PopEnvironment,
            configuration.ResetEnvironment, configuration.SetEnvironmentVariable,
            configuration.UnsetEnvironmentVariable, configuration.AppendEnvironmentVariable,
            process.ExecuteLocal, process.ExecuteProcess, description.IncludeLaunchDescription,
            ShutdownAction=event_handlers.Shutdown),
        'launch.actions.shutdown_action': _named(
            event_handlers.Shutdown, ShutdownEvent=events.Shutdown),
        'launch.conditions': _named(
            configuration.IfCondition, configuration.UnlessCondition,
            configuration.LaunchConfigurationEquals, configuration.LaunchConfigurationNotEquals,
            configuration.evaluate_condition_expression,
            configuration.InvalidConditionExpressionError),
        'launch.substitutions': _named(
            substitutions.LaunchConfiguration, substitutions.EnvironmentVariable,
            substitutions.StringJoinSubstitution, substitutions.AnonName,
            substitutions.LocalSubstitution, substitutions.ForLoopIndex, substitutions.ForEachVar,
            substitutions.IfElseSubstitution, paths.PathJoinSubstitution, paths.PathSubstitution,
            paths.ThisLaunchFile, paths.ThisLaunchFileDir, paths.LaunchLogDir, paths.FileContent,
            programs.FindExecutable, programs.Command, programs.PythonExpression,
            context.TextSubstitution, substitutions.EqualsSubstitution,
            substitutions.NotEqualsSubstitution, failures.SubstitutionFailure,
            LaunchLogDirectory=paths.LaunchLogDir, **booleans),
        'launch.substitutions.boolean_substitution': booleans,
        'launch.event_handlers': _named(
            event_handlers.OnProcessStart, event_handlers.OnProcessExit,
            event_handlers.OnProcessIO, event_handlers.OnExecutionComplete,
            event_handlers.OnShutdown, event_handlers.OnIncludeLaunchDescription),
        'launch.events': _named(
            events.Shutdown, events.TimerEvent, events.IncludeLaunchDescription,
            events.ExecutionComplete, events.matches_action, events.Event),
        'launch.events.process': _named(
            events.ProcessStarted, events.ProcessExited, events.ProcessIO, events.ProcessStdin,
            events.ProcessStdout, events.ProcessStderr, events.ShutdownProcess,
            events.SignalProcess, events.ProcessTargetedEvent, events.RunningProcessEvent,
            events.matches_executable, events.matches_name, events.matches_pid),
        'launch.launch_description_sources': _named(
            description.PythonLaunchDescriptionSource, description.AnyLaunchDescriptionSource,
            description.FrontendLaunchDescriptionSource, description.XMLLaunchDescriptionSource,
            description.YAMLLaunchDescriptionSource, description.load_python_launch_file_as_module,
            description.get_launch_description_from_python_launch_file,
            failures.InvalidLaunchFileError),
        'launch.frontend': _named(
            files.expose_action, files.expose_substitution, parser.Parser, Entity=syntax.Element,
            InvalidFrontendLaunchFileError=failures.InvalidLaunchFileError),
        'launch.frontend.parse_substitution': _named(syntax.parse_substitution),
        'launch.frontend.expose': _named(files.expose_action, files.expose_substitution),
        'launch.utilities': _named(
            context.perform_substitutions, context.normalize_to_list_of_substitutions,
            context.normalize_to_list_of_entities, utilities.ensure_argument_type,
            utilities.is_a, utilities.is_a_subclass, utilities.create_future),
        'launch.utilities.type_utils': _named(
            utilities.is_a, utilities.normalize_typed_substitution,
            utilities.perform_typed_substitution, coerce_to_type=context.coerce),
        'launch.substitutions.substitution_failure': _named(failures.SubstitutionFailure),
        'launch.logging': _named(
            actions.get_logger, actions.launch_config, actions.get_output_loggers),
        'launch.descriptions': _named(process.Executable),
        'launch.descriptions.executable': _named(process.Executable),
    }


def _launch_xml() -> Table:
    from armsim_ros.launch.api.description import XMLLaunchDescriptionSource

    return {'launch_xml.launch_description_sources': _named(XMLLaunchDescriptionSource)}


def _launch_yaml() -> Table:
    from armsim_ros.launch.api.description import YAMLLaunchDescriptionSource

    return {'launch_yaml.launch_description_sources': _named(YAMLLaunchDescriptionSource)}


def _launch_ros() -> Table:
    from armsim_ros.launch.api import (
        context,
        event_handlers,
        events,
        namespaces,
        paths,
        ros_node,
        ros_parameters,
    )

    packages = _named(paths.FindPackage, paths.FindPackageShare, paths.FindPackagePrefix)
    return {
        'launch_ros': _named(ros_node.RosExecutable),
        'launch_ros.actions': _named(
            ros_node.Node, ros_node.LifecycleNode, ros_node.PushRosNamespace,
            ros_node.SetParameter, ros_node.SetParametersFromFile, ros_node.SetUseSimTime,
            ros_node.SetRemap, ros_node.SetROSLogDir, ros_node.ComposableNodeContainer,
            ros_node.LoadComposableNodes, event_handlers.RosTimer,
            event_handlers.LifecycleTransition, PushROSNamespace=ros_node.PushRosNamespace,
            ROSTimer=event_handlers.RosTimer),
        'launch_ros.descriptions': _named(
            ros_node.ComposableNode, ros_node.ComposableLifecycleNode, ros_parameters.Parameter,
            ros_parameters.ParameterValue, ros_parameters.ParameterFile),
        'launch_ros.parameter_descriptions': _named(
            ros_parameters.Parameter, ros_parameters.ParameterValue, ros_parameters.ParameterFile,
            ros_parameters.ParameterDescription),
        'launch_ros.substitutions': _named(
            paths.ExecutableInPackage, paths.Parameter, **packages),
        'launch_ros.substitutions.find_package': {
            **packages, **_named(paths.get_package_share_directory, paths.get_package_prefix)},
        'launch_ros.event_handlers': _named(event_handlers.OnStateTransition),
        'launch_ros.events.lifecycle': _named(
            events.ChangeState, events.StateTransition, events.matches_node_name),
        'launch_ros.events': _named(events.matches_node_name),
        'launch_ros.utilities': _named(
            ros_parameters.evaluate_parameters, ros_parameters.normalize_parameters,
            namespaces.is_namespace_absolute, namespaces.is_root_namespace,
            namespaces.make_namespace_absolute, namespaces.prefix_namespace),
        'launch_ros.parameters_type': _named(
            ros_parameters.ParameterFile, ros_parameters.ParameterValue,
            SomeParameters=ros_parameters.SomeParameters,
            SomeParametersDict=ros_parameters.SomeParametersDict,
            SomeParameterFile=ros_parameters.SomeParameterFile,
            SomeParameterValue=ros_parameters.SomeParameterValue),
        'launch_ros.remap_rule_type': _named(SomeRemapRules=context.SomeText),
    }


def _ament_index_python() -> Table:
    from armsim_ros.launch.api import paths
    from armsim_ros.launch.failures import MissingPackageError

    packages = _named(
        paths.get_package_share_directory, paths.get_package_share_path, paths.get_package_prefix,
        paths.get_packages_with_prefixes, PackageNotFoundError=MissingPackageError)
    resources = _named(paths.has_resource, paths.get_resource, paths.get_resources)
    search_paths = _named(paths.get_search_paths)
    return {
        'ament_index_python': {**packages, **resources, **search_paths},
        'ament_index_python.packages': packages,
        'ament_index_python.resources': resources,
        'ament_index_python.search_paths': search_paths,
    }


def _launch_param_builder() -> Table:
    from armsim_ros.launch.api import moveit_configs, paths

    return {
        'launch_param_builder': _named(
            moveit_configs.ParameterBuilder, moveit_configs.load_yaml, moveit_configs.load_xacro,
            moveit_configs.load_file, moveit_configs.get_path, paths.get_package_share_directory),
        'launch_param_builder.parameter_builder': _named(moveit_configs.ParameterBuilder),
        'launch_param_builder.utils': _named(
            moveit_configs.load_yaml, moveit_configs.load_xacro, moveit_configs.load_file,
            moveit_configs.ParameterBuilderFileNotFoundError),
    }


def _nav2_common() -> Table:
    from armsim_ros.launch.api import nav2

    return {
        'nav2_common.launch': _named(
            nav2.ReplaceString, nav2.RewrittenYaml, nav2.HasNodeParams, nav2.LaunchConfigAsBool,
            nav2.ParseMultiRobotPose),
    }


def _moveit_configs_utils() -> Table:
    from armsim_ros.launch.api import launches, moveit_configs

    return {
        'moveit_configs_utils': _named(
            moveit_configs.MoveItConfigsBuilder, moveit_configs.MoveItConfigs),
        'moveit_configs_utils.moveit_configs_builder': _named(
            moveit_configs.MoveItConfigsBuilder, moveit_configs.MoveItConfigs,
            moveit_configs.get_pattern_matches),
        'moveit_configs_utils.launches': _named(
            launches.generate_demo_launch, launches.generate_move_group_launch,
            launches.generate_moveit_rviz_launch, launches.generate_rsp_launch,
            launches.generate_setup_assistant_launch, launches.generate_spawn_controllers_launch,
            launches.generate_static_virtual_joint_tfs_launch,
            launches.generate_warehouse_db_launch),
        'moveit_configs_utils.launch_utils': _named(
            launches.DeclareBooleanLaunchArg, launches.add_debuggable_node),
        'moveit_configs_utils.substitutions': _named(launches.Xacro),
    }


def _controller_manager() -> Table:
    from armsim_ros.launch.api import launches

    return {
        'controller_manager.launch_utils': _named(
            launches.generate_load_controller_launch_description,
            launches.generate_controllers_spawner_launch_description,
            launches.generate_controllers_spawner_launch_description_from_dict,
            launches.generate_spawner_launch_description),
    }


#: Name of upstream's package -> its modules.
TABLES: Mapping[str, Callable[[], Table]] = {
    'launch': _launch,
    'launch_xml': _launch_xml,
    'launch_yaml': _launch_yaml,
    'launch_ros': _launch_ros,
    'ament_index_python': _ament_index_python,
    'launch_param_builder': _launch_param_builder,
    'nav2_common': _nav2_common,
    'moveit_configs_utils': _moveit_configs_utils,
    'controller_manager': _controller_manager,
}
