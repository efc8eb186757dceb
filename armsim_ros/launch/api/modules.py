# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which names of this package replace which names of upstream's modules.

A function per distribution, called when a launch file imports from it; most need two of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

#: Module of upstream -> name in it -> object of this package.
Table = dict[str, dict[str, Any]]


def _named(*objects: Any, **renamed: Any) -> dict[str, Any]:
    """Return objects by their own names, and others by upstream's."""
    return {**{each.__name__: each for each in objects}, **renamed}


def _launch() -> Table:
    from armsim_ros.launch import failures
    from armsim_ros.launch import files as launch_files
    from armsim_ros.launch.api import (
        conditions,
        context,
        description,
        event_handlers,
        events,
        include,
        process,
        utilities,
    )
    from armsim_ros.launch.api.actions import (
        configuration,
        groups,
        logs,
    )
    from armsim_ros.launch.api.actions import (
        events as event_actions,
    )
    from armsim_ros.launch.api.substitutions import booleans, files, programs, texts
    from armsim_ros.launch.frontend import element, parser

    return {
        'launch': _named(
            description.LaunchDescription, context.LaunchContext, context.LaunchDescriptionEntity,
            context.Action, context.Substitution, conditions.Condition, events.Event,
            event_handlers.EventHandler, include.LaunchDescriptionSource,
            description.LaunchService, description.LaunchIntrospector,
            SomeSubstitutionsType=context.SomeText),
        'launch.launch_description': _named(description.LaunchDescription),
        'launch.launch_context': _named(context.LaunchContext),
        'launch.launch_description_entity': _named(context.LaunchDescriptionEntity),
        'launch.launch_description_source': _named(include.LaunchDescriptionSource),
        'launch.launch_service': _named(description.LaunchService),
        'launch.launch_introspector': _named(description.LaunchIntrospector),
        'launch.action': _named(context.Action),
        'launch.condition': _named(conditions.Condition),
        'launch.substitution': _named(context.Substitution),
        'launch.event': _named(events.Event),
        'launch.event_handler': _named(
            event_handlers.EventHandler, event_handlers.BaseEventHandler),
        'launch.some_substitutions_type': _named(SomeSubstitutionsType=context.SomeText),
        'launch.some_entities_type': _named(SomeEntitiesType=context.LaunchDescriptionEntity),
        'launch.some_actions_type': _named(SomeActionsType=context.LaunchDescriptionEntity),
        'launch.actions': _named(
            groups.GroupAction, groups.OpaqueFunction, groups.OpaqueCoroutine, logs.LogInfo,
            logs.Log, logs.LogDebug, logs.LogWarning, logs.LogError, event_actions.TimerAction,
            event_actions.RegisterEventHandler, event_actions.UnregisterEventHandler,
            event_actions.EmitEvent, event_actions.Shutdown, groups.ForLoop, groups.ForEach,
            configuration.DeclareLaunchArgument, configuration.SetLaunchConfiguration,
            configuration.UnsetLaunchConfiguration, configuration.ResetLaunchConfigurations,
            configuration.PushLaunchConfigurations, configuration.PopLaunchConfigurations,
            configuration.PushEnvironment, configuration.PopEnvironment,
            configuration.ResetEnvironment, configuration.SetEnvironmentVariable,
            configuration.UnsetEnvironmentVariable, configuration.AppendEnvironmentVariable,
            process.ExecuteLocal, process.ExecuteProcess, include.IncludeLaunchDescription,
            ShutdownAction=event_actions.Shutdown),
        'launch.conditions': _named(
            conditions.IfCondition, conditions.UnlessCondition,
            conditions.LaunchConfigurationEquals, conditions.LaunchConfigurationNotEquals,
            conditions.evaluate_condition_expression, conditions.InvalidConditionExpressionError),
        'launch.substitutions': _named(
            texts.LaunchConfiguration, texts.EnvironmentVariable, texts.StringJoinSubstitution,
            texts.AnonName, texts.LocalSubstitution, texts.ForLoopIndex, texts.ForEachVar,
            texts.IfElseSubstitution, files.PathJoinSubstitution, files.PathSubstitution,
            files.ThisLaunchFile, files.ThisLaunchFileDir, files.LaunchLogDir, files.FileContent,
            programs.FindExecutable, programs.Command, programs.PythonExpression,
            utilities.TextSubstitution, booleans.AndSubstitution, booleans.OrSubstitution,
            booleans.NotSubstitution, booleans.AllSubstitution, booleans.AnySubstitution,
            booleans.EqualsSubstitution, booleans.NotEqualsSubstitution,
            failures.SubstitutionFailure, LaunchLogDirectory=files.LaunchLogDir),
        'launch.event_handlers': _named(
            event_handlers.OnProcessStart, event_handlers.OnProcessExit,
            event_handlers.OnProcessIO, event_handlers.OnExecutionComplete,
            event_handlers.OnShutdown),
        'launch.events': _named(
            events.Shutdown, events.TimerEvent, events.IncludeLaunchDescription,
            events.ExecutionComplete, events.matches_action, events.Event),
        'launch.events.process': _named(
            events.ProcessStarted, events.ProcessExited, events.ProcessIO, events.ProcessStdin,
            events.ProcessStdout, events.ProcessStderr, events.ShutdownProcess,
            events.SignalProcess, events.ProcessTargetedEvent, events.matches_executable,
            events.matches_name, events.matches_pid),
        'launch.launch_description_sources': _named(
            include.PythonLaunchDescriptionSource, include.AnyLaunchDescriptionSource,
            include.FrontendLaunchDescriptionSource, include.XMLLaunchDescriptionSource,
            include.YAMLLaunchDescriptionSource, include.load_python_launch_file_as_module,
            include.get_launch_description_from_python_launch_file,
            failures.InvalidLaunchFileError),
        'launch.frontend': _named(
            launch_files.expose_action, launch_files.expose_substitution, parser.Parser,
            Entity=element.Element),
        'launch.frontend.expose': _named(
            launch_files.expose_action, launch_files.expose_substitution),
        'launch.utilities': _named(
            utilities.perform_substitutions, utilities.normalize_to_list_of_substitutions,
            utilities.normalize_to_list_of_entities, utilities.ensure_argument_type,
            utilities.is_a, utilities.is_a_subclass, utilities.create_future),
        'launch.utilities.type_utils': _named(
            utilities.is_a, perform_typed_substitution=utilities.coerce),
        'launch.substitutions.substitution_failure': _named(failures.SubstitutionFailure),
        'launch.logging': _named(
            logs.get_logger, logs.launch_config,
            logs.get_output_loggers),
        'launch.descriptions': _named(process.Executable),
        'launch.descriptions.executable': _named(process.Executable),
    }


def _launch_xml() -> Table:
    from armsim_ros.launch.api import include

    return {
        'launch_xml.launch_description_sources': _named(include.XMLLaunchDescriptionSource),
    }


def _launch_yaml() -> Table:
    from armsim_ros.launch.api import include

    return {
        'launch_yaml.launch_description_sources': _named(include.YAMLLaunchDescriptionSource),
    }


def _launch_ros() -> Table:
    from armsim_ros.launch.api import (
        context,
        event_handlers,
        events,
        ros_components,
        ros_node,
        ros_parameters,
    )
    from armsim_ros.launch.api.actions import events as event_actions
    from armsim_ros.launch.api.substitutions import packages

    return {
        'launch_ros': _named(ros_node.RosExecutable),
        'launch_ros.actions': _named(
            ros_node.Node, ros_node.LifecycleNode, ros_node.PushRosNamespace,
            ros_node.SetParameter, ros_node.SetParametersFromFile, ros_node.SetUseSimTime,
            ros_node.SetRemap, ros_node.SetROSLogDir, ros_components.ComposableNodeContainer,
            ros_components.LoadComposableNodes, event_actions.RosTimer,
            event_actions.LifecycleTransition,
            PushROSNamespace=ros_node.PushRosNamespace, ROSTimer=event_actions.RosTimer),
        'launch_ros.descriptions': _named(
            ros_components.ComposableNode, ros_components.ComposableLifecycleNode,
            ros_parameters.Parameter, ros_parameters.ParameterValue, ros_parameters.ParameterFile),
        'launch_ros.parameter_descriptions': _named(
            ros_parameters.Parameter, ros_parameters.ParameterValue, ros_parameters.ParameterFile,
            ros_parameters.ParameterDescription),
        'launch_ros.substitutions': _named(
            packages.FindPackage, packages.FindPackageShare, packages.FindPackagePrefix,
            packages.ExecutableInPackage, packages.Parameter),
        'launch_ros.event_handlers': _named(event_handlers.OnStateTransition),
        'launch_ros.events.lifecycle': _named(
            events.ChangeState, events.StateTransition, events.matches_node_name),
        'launch_ros.events': _named(events.matches_node_name),
        'launch_ros.utilities': _named(
            ros_parameters.evaluate_parameters, make_namespace_absolute=ros_node.make_namespace),
        'launch_ros.remap_rule_type': _named(SomeRemapRules=context.SomeText),
    }


def _ament_index_python() -> Table:
    from armsim_ros.launch.api.substitutions import packages
    from armsim_ros.launch.failures import MissingPackageError

    return {
        'ament_index_python': _named(
            packages.get_package_share_directory, packages.get_package_share_path,
            packages.get_package_prefix, packages.get_packages_with_prefixes,
            packages.get_search_paths, packages.has_resource, packages.get_resource,
            packages.get_resources, PackageNotFoundError=MissingPackageError),
        'ament_index_python.packages': _named(
            packages.get_package_share_directory, packages.get_package_share_path,
            packages.get_package_prefix, packages.get_packages_with_prefixes,
            PackageNotFoundError=MissingPackageError),
        'ament_index_python.resources': _named(
            packages.has_resource, packages.get_resource, packages.get_resources),
        'ament_index_python.search_paths': _named(packages.get_search_paths),
    }


def _launch_param_builder() -> Table:
    from armsim_ros.launch.api import param_builder

    return {
        'launch_param_builder': _named(
            param_builder.ParameterBuilder, param_builder.load_yaml, param_builder.load_xacro,
            param_builder.load_file, param_builder.get_path),
        'launch_param_builder.parameter_builder': _named(param_builder.ParameterBuilder),
        'launch_param_builder.utils': _named(
            param_builder.load_yaml, param_builder.load_xacro, param_builder.load_file,
            param_builder.ParameterBuilderFileNotFoundError),
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
            moveit_configs.MoveItConfigsBuilder, moveit_configs.MoveItConfigs),
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
