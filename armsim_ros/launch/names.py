# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The names under which launch files import the classes of ``armsim_ros.launch.api``.

They can be imported only inside :func:`importable`, and all but three of them only where no real
module has the name. Afterwards they are gone from ``sys.modules``, and what was there is back.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location
import re
import sys
from types import ModuleType
from typing import Any

from armsim_ros.launch.lookup import Lookup

_API = 'armsim_ros.launch.api.'
_DESCRIPTION = 'description:LaunchDescription'
_MOVEIT_LAUNCHES = ' '.join(f'moveit.launches:generate_{name}_launch' for name in (
    'demo', 'move_group', 'moveit_rviz', 'rsp', 'setup_assistant', 'spawn_controllers',
    'static_virtual_joint_tfs', 'warehouse_db'))

#: Module -> its content as ``file:Name,Name``; ``Name=Other`` renames Name to Other.
MODULES: Mapping[str, str] = {
    'launch': f'{_DESCRIPTION} context:LaunchContext entity:LaunchDescriptionEntity entity:Action '
              'entity:Substitution conditions:Condition events:Event event_handlers:EventHandler '
              'include:LaunchDescriptionSource service:LaunchService '
              'service:LaunchIntrospector entity:SomeText=SomeSubstitutionsType',
    'launch.launch_description': _DESCRIPTION,
    'launch.launch_context': 'context:LaunchContext',
    'launch.launch_description_entity': 'entity:LaunchDescriptionEntity',
    'launch.launch_description_source': 'include:LaunchDescriptionSource',
    'launch.launch_service': 'service:LaunchService',
    'launch.launch_introspector': 'service:LaunchIntrospector',
    'launch.action': 'entity:Action',
    'launch.condition': 'conditions:Condition',
    'launch.substitution': 'entity:Substitution',
    'launch.event': 'events:Event',
    'launch.event_handler': 'event_handlers:EventHandler event_handlers:BaseEventHandler',
    'launch.some_substitutions_type': 'entity:SomeText=SomeSubstitutionsType',
    'launch.some_entities_type': 'entity:LaunchDescriptionEntity=SomeEntitiesType',
    'launch.some_actions_type': 'entity:LaunchDescriptionEntity=SomeActionsType',
    'launch.actions':
        'actions.groups:GroupAction,OpaqueFunction,OpaqueCoroutine '
        'actions.logs:LogInfo,Log,LogDebug,LogWarning,LogError '
        'actions.events:TimerAction,RegisterEventHandler,UnregisterEventHandler,EmitEvent,'
        'Shutdown,Shutdown=ShutdownAction actions.loops:ForLoop,ForEach '
        'actions.configuration:DeclareLaunchArgument,SetLaunchConfiguration,'
        'UnsetLaunchConfiguration,ResetLaunchConfigurations,PushLaunchConfigurations,'
        'PopLaunchConfigurations,PushEnvironment,PopEnvironment,ResetEnvironment,'
        'SetEnvironmentVariable,UnsetEnvironmentVariable,AppendEnvironmentVariable '
        'process:ExecuteLocal,ExecuteProcess include:IncludeLaunchDescription',
    'launch.conditions':
        'conditions:IfCondition conditions:UnlessCondition conditions:LaunchConfigurationEquals '
        'conditions:LaunchConfigurationNotEquals conditions:evaluate_condition_expression '
        'conditions:InvalidConditionExpressionError',
    'launch.substitutions':
        'substitutions.texts:LaunchConfiguration,EnvironmentVariable,StringJoinSubstitution,'
        'AnonName,LocalSubstitution,ForLoopIndex,ForEachVar,IfElseSubstitution '
        'substitutions.files:PathJoinSubstitution,PathSubstitution,ThisLaunchFile,'
        'ThisLaunchFileDir,LaunchLogDir,LaunchLogDir=LaunchLogDirectory,FileContent '
        'substitutions.programs:FindExecutable,Command,PythonExpression '
        'utilities:TextSubstitution '
        'substitutions.booleans:AndSubstitution,OrSubstitution,NotSubstitution,'
        'AllSubstitution,AnySubstitution,EqualsSubstitution,NotEqualsSubstitution '
        'failures:SubstitutionFailure',
    'launch.event_handlers':
        'event_handlers:OnProcessStart event_handlers:OnProcessExit event_handlers:OnProcessIO '
        'event_handlers:OnExecutionComplete event_handlers:OnShutdown',
    'launch.events':
        'events:Shutdown events:TimerEvent events:IncludeLaunchDescription '
        'events:ExecutionComplete events:matches_action events:Event',
    'launch.events.process':
        'events:ProcessStarted events:ProcessExited events:ProcessIO events:ProcessStdin '
        'events:ProcessStdout events:ProcessStderr events:ShutdownProcess events:SignalProcess '
        'events:ProcessTargetedEvent events:matches_executable events:matches_name '
        'events:matches_pid',
    'launch.launch_description_sources':
        'include:PythonLaunchDescriptionSource include:AnyLaunchDescriptionSource '
        'include:FrontendLaunchDescriptionSource '
        'include:XMLLaunchDescriptionSource include:YAMLLaunchDescriptionSource '
        'include:load_python_launch_file_as_module '
        'include:get_launch_description_from_python_launch_file '
        'failures:InvalidLaunchFileError',
    'launch.frontend': 'frontend:expose_action frontend:expose_substitution frontend:Entity '
                       'frontend:Parser',
    'launch.frontend.expose': 'frontend:expose_action frontend:expose_substitution',
    'launch.utilities':
        'utilities:perform_substitutions utilities:normalize_to_list_of_substitutions '
        'utilities:normalize_to_list_of_entities utilities:ensure_argument_type utilities:is_a '
        'utilities:is_a_subclass utilities:create_future',
    'launch.utilities.type_utils': 'utilities:coerce=perform_typed_substitution utilities:is_a',
    'launch.substitutions.substitution_failure': 'failures:SubstitutionFailure',
    'launch.logging': 'launch_logging:get_logger launch_logging:launch_config '
                      'launch_logging:get_output_loggers',
    'launch.descriptions': 'process:Executable',
    'launch.descriptions.executable': 'process:Executable',
    'launch_xml.launch_description_sources': 'include:XMLLaunchDescriptionSource',
    'launch_yaml.launch_description_sources': 'include:YAMLLaunchDescriptionSource',
    'launch_ros': 'ros_node:RosExecutable',
    'launch_ros.actions':
        'ros_node:Node ros_node:LifecycleNode ros_node:PushRosNamespace '
        'ros_node:PushRosNamespace=PushROSNamespace ros_node:SetParameter '
        'ros_node:SetParametersFromFile ros_node:SetUseSimTime ros_node:SetRemap '
        'ros_node:SetROSLogDir ros_components:ComposableNodeContainer '
        'ros_components:LoadComposableNodes ros_timer:RosTimer=ROSTimer ros_timer:RosTimer '
        'ros_timer:LifecycleTransition',
    'launch_ros.descriptions':
        'ros_components:ComposableNode ros_components:ComposableLifecycleNode '
        'ros_parameters:Parameter ros_parameters:ParameterValue ros_parameters:ParameterFile',
    'launch_ros.parameter_descriptions':
        'ros_parameters:Parameter ros_parameters:ParameterValue ros_parameters:ParameterFile '
        'ros_parameters:ParameterDescription',
    'launch_ros.substitutions':
        'substitutions.packages:FindPackage substitutions.packages:FindPackageShare '
        'substitutions.packages:FindPackagePrefix substitutions.packages:ExecutableInPackage '
        'substitutions.packages:Parameter',
    'launch_ros.event_handlers': 'event_handlers:OnStateTransition',
    'launch_ros.events.lifecycle':
        'events:ChangeState events:StateTransition events:matches_node_name',
    'launch_ros.events': 'events:matches_node_name',
    'launch_ros.utilities': 'ros_parameters:evaluate_parameters ros_node:make_namespace='
                            'make_namespace_absolute',
    'launch_ros.remap_rule_type': 'entity:SomeText=SomeRemapRules',
    'ament_index_python':
        'ament_index:get_package_share_directory ament_index:get_package_share_path '
        'ament_index:get_package_prefix ament_index:get_packages_with_prefixes '
        'ament_index:get_search_paths ament_index:has_resource ament_index:get_resource '
        'ament_index:get_resources ament_index:PackageNotFoundError',
    'ament_index_python.packages':
        'ament_index:get_package_share_directory ament_index:get_package_share_path '
        'ament_index:get_package_prefix ament_index:get_packages_with_prefixes '
        'ament_index:PackageNotFoundError',
    'ament_index_python.resources':
        'ament_index:has_resource ament_index:get_resource ament_index:get_resources',
    'ament_index_python.search_paths': 'ament_index:get_search_paths',
    'launch_param_builder':
        'param_builder:ParameterBuilder param_builder:load_yaml param_builder:load_xacro '
        'param_builder:load_file param_builder:get_path',
    'launch_param_builder.parameter_builder': 'param_builder:ParameterBuilder',
    'launch_param_builder.utils':
        'param_builder:load_yaml param_builder:load_xacro param_builder:load_file '
        'param_builder:ParameterBuilderFileNotFoundError',
    'nav2_common.launch':
        'nav2:ReplaceString nav2:RewrittenYaml nav2:HasNodeParams nav2:LaunchConfigAsBool '
        'nav2:ParseMultiRobotPose',
    'moveit_configs_utils':
        'moveit.configs:MoveItConfigsBuilder moveit.configs:MoveItConfigs',
    'moveit_configs_utils.moveit_configs_builder':
        'moveit.configs:MoveItConfigsBuilder moveit.configs:MoveItConfigs',
    'moveit_configs_utils.launches': _MOVEIT_LAUNCHES,
    'moveit_configs_utils.launch_utils':
        'moveit.launch_utils:DeclareBooleanLaunchArg moveit.launch_utils:add_debuggable_node',
    'moveit_configs_utils.substitutions': 'moveit.launch_utils:Xacro',
    'controller_manager.launch_utils':
        'controller_manager:generate_load_controller_launch_description '
        'controller_manager:generate_controllers_spawner_launch_description '
        'controller_manager:generate_controllers_spawner_launch_description_from_dict '
        'controller_manager:generate_spawner_launch_description',
}

#: Ours while a file is evaluated here, also where real ones are installed: the real index finds no
#: sources, and the real classes need the real event loop, which `ros2 launch` runs.
_ALWAYS_OURS = ('ament_index_python', 'launch', 'launch_ros')


class _Finder(MetaPathFinder, Loader):
    """
    Finds the modules of the table, and Python packages in the sources of ROS packages.

    :param lookup: finds those.
    """

    def __init__(self, lookup: Lookup, names: Sequence[str]) -> None:
        self._lookup = lookup
        self._names = names
        self.made: list[str] = []

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        top = fullname.partition('.')[0]
        if top in self._names:
            if (fullname in MODULES or _class_of(fullname) is not None
                    or any(module.startswith(f'{fullname}.') for module in MODULES)):
                return ModuleSpec(fullname, self, is_package=True)
            return None
        return self._source_package(fullname) if top == fullname else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = ModuleType(spec.name)
        module.__path__ = []
        return module

    def exec_module(self, module: ModuleType) -> None:
        self.made.append(module.__name__)
        found = _class_of(module.__name__)
        for file, source, name in _entries(module.__name__) or ([found] if found else []):
            home = 'armsim_ros.launch.failures' if file == 'failures' else _API + file
            if file == 'frontend':
                home = 'armsim_ros.launch.frontend.exposed'
            setattr(module, name, getattr(import_module(home), source))
        for child in _children(module.__name__):
            # launch_ros.actions is there after 'import launch_ros' alone.
            setattr(module, child.rpartition('.')[2], import_module(child))

    def _source_package(self, name: str) -> Any:
        place = self._lookup.module(name)
        if place is None:
            return None
        self.made.append(name)
        if place.is_file():
            return spec_from_file_location(name, place)
        return spec_from_file_location(
            name, place / '__init__.py', submodule_search_locations=[str(place)])


@contextmanager
def importable(lookup: Lookup) -> Iterator[None]:
    """
    Make the modules of launch files importable.

    :param lookup: finds the packages that they name.
    """
    tops = dict.fromkeys(name.partition('.')[0] for name in MODULES)
    ours = [name for name in tops if name in _ALWAYS_OURS or not _is_real(name)]
    finder = _Finder(lookup, ours)
    hidden = {name: module for name, module in sys.modules.items()
              if name.partition('.')[0] in _ALWAYS_OURS}
    for name in hidden:
        del sys.modules[name]
    first = _First(finder, ours)
    before_path = list(sys.path)
    no_bytecode = sys.dont_write_bytecode
    # Nothing of the user's code is cached.
    sys.dont_write_bytecode = True
    sys.meta_path.insert(0, first)
    sys.meta_path.append(finder)
    try:
        yield
    finally:
        sys.meta_path.remove(first)
        sys.meta_path.remove(finder)
        for name in list(sys.modules):
            if name.partition('.')[0] in {made.partition('.')[0] for made in finder.made}:
                del sys.modules[name]
        sys.modules.update(hidden)
        sys.path[:] = before_path
        sys.dont_write_bytecode = no_bytecode


class _First(MetaPathFinder):
    """Finds ours before folders of their names, such as launch/ under the working folder."""

    def __init__(self, finder: _Finder, names: Sequence[str]) -> None:
        self._finder = finder
        self._names = names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        if fullname.partition('.')[0] in self._names:
            return self._finder.find_spec(fullname, path, target)
        return None


def _is_real(name: str) -> bool:
    """Return whether a real module of this name can be imported."""
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        return False
    if spec is None:
        return False
    # A folder without __init__.py beside the working folder is no package: launch/ of a package.
    return spec.origin is not None


def _children(name: str) -> list[str]:
    depth = name.count('.') + 1
    found = {'.'.join(module.split('.')[:depth + 1]) for module in MODULES
             if module.startswith(f'{name}.')}
    return sorted(found)


def _entries(module: str) -> list[tuple[str, str, str]]:
    """Return file, name, and name in the module, of all that a module of the table has."""
    found = []
    for word in MODULES.get(module, '').split():
        file, _, names = word.partition(':')
        for name in names.split(','):
            source, _, other = name.partition('=')
            found.append((file, source, other or source))
    return found


def _class_of(name: str) -> tuple[str, str, str] | None:
    """Return the class of a module that is named after it, such as actions.execute_process."""
    parent, _, last = name.rpartition('.')
    for entry in _entries(parent):
        if re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', entry[2]).lower() == last:
            return entry
    return None
