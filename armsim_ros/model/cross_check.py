# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the settings name what the robot has; each error with its place in the file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from armsim_ros.config.controllers.controller_settings import BROADCASTER
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ignored, Location, nearest, Problem, Severity
from armsim_ros.model.description.urdf import UrdfContent
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.model.semantic_model import PlanningGroup


def check_settings(settings: RobotSettings, model: RobotModel,
                   places: Mapping[str, Location] | None = None, *,
                   partial: bool = False) -> list[Problem]:
    """
    Return every place where settings and robot do not fit.

    :param places: 'joint x', 'group x' ... -> where the URDF or SRDF has it.
    :param partial: whether files had errors, which may be why something is missing.
    """
    check = _Check(settings, model, places or {})
    check.controllers()
    check.joints_in_settings()
    check.joint_limits()
    check.hardware()
    if not partial:
        check.moveit_controllers()
        check.groups_in_settings()
        check.coverage()
    return check.problems


def fitting_controllers(settings: RobotSettings, model: RobotModel) -> tuple[str, ...]:
    """Return those of the controllers to spawn whose joints the robot has and can drive."""
    def drives(name: str) -> bool:
        joint = model.joints.get(name.rpartition('/')[2])
        return joint is not None and joint.active

    found = (settings.controller(name) for name in settings.spawn)
    return tuple(controller.name for controller in found if controller is not None
                 and all(map(drives, controller.joints)))


class _Check:
    """A run over settings and model."""

    def __init__(self, settings: RobotSettings, model: RobotModel,
                 places: Mapping[str, Location]) -> None:
        self._settings, self._model, self._places = settings, model, places
        self.problems: list[Problem] = []

    def controllers(self) -> None:
        """Check that each controller's joints are there and can be commanded."""
        for controller in self._settings.controllers:
            title = f"controller '{controller.name}'"
            fields = type(controller.parameters).model_fields
            key = next((key for key in ('joint', 'dof_names') if key in fields), 'joints')
            for position, joint in enumerate(controller.joints):
                path = ('controllers', controller.name, key)
                where = self._settings.locate(*path, position) or self._settings.locate(*path)
                if not self._of_controller(joint):
                    self._check_commanded(title, joint, where)
            if controller.type == BROADCASTER:
                for position, joint in enumerate(controller.parameters.joints):
                    where = self._settings.locate(
                        'controllers', controller.name, 'joints', position)
                    self._known_joint(title, joint, where, Severity.ERROR)

    def hardware(self) -> None:
        """Warn of joints that planning needs and no declared hardware reports."""
        if not self._model.hardware:
            return
        for group in self._model.semantic.groups.values():
            lost = [joint for joint in self._model.controlled_joints(group.name)
                    if joint not in self._model.hardware_joints]
            if lost:
                self._add(
                    f"planning group '{group.name}' has {', '.join(lost)}, which no "
                    '<ros2_control> has: no node publishes their positions',
                    self._places.get(f'group {group.name}'),
                    remedy='add them to a <ros2_control> with a state_interface')

    def moveit_controllers(self) -> None:
        """Check the joints of move_group's controllers, and that their action is served."""
        served = {self._relative(controller.name): controller
                  for controller in self._settings.controllers}
        for controller in self._settings.moveit_controllers:
            title = f"MoveIt controller '{controller.name}'"
            for position, joint in enumerate(controller.joints):
                where = self._settings.locate('moveit_controllers', controller.name, 'joints',
                                              position)
                self._known_joint(title, joint, where, Severity.ERROR)
            if controller.name.strip('/') not in served:
                known = tuple(served)
                self._add(
                    f'{title}: no controller of this name runs here, so its action '
                    f"'{controller.action_name}' is not served",
                    self._settings.locate('moveit_controllers', controller.name),
                    allowed=', '.join(known), remedy=nearest(controller.name.strip('/'), known))

    def joints_in_settings(self) -> None:
        """Check the joints that the other files name."""
        paths: tuple[tuple[str, tuple[str, ...], Iterable[str]], ...] = (
            ('joint limits', ('joint_limits', 'joint_limits'),
             self._settings.joint_limits.joint_limits),
            ('servo gains', ('simulation', 'servo', 'gains'),
             self._settings.simulation.servo.gains),
            ('start tolerances', ('trajectory_execution', 'allowed_start_tolerance_joints'),
             self._settings.trajectory_execution.allowed_start_tolerance_joints))
        for title, path, joints in paths:
            for joint in joints:
                self._known_joint(title, joint, self._settings.locate(*path, joint),
                                  Severity.WARNING)

    def joint_limits(self) -> None:
        """Report what joint_limits.yaml gives and no plan is bounded by."""
        for name, limits in self._settings.joint_limits.joint_limits.items():
            path = ('joint_limits', 'joint_limits', name)
            joint = self._model.joints.get(name)
            if joint is not None and joint.type is JointType.CONTINUOUS:
                for key in ('min_position', 'max_position'):
                    if getattr(limits, key) is not None:
                        self._add(f"joint limits: '{key}' of continuous joint '{name}' has no "
                                  'effect', self._settings.locate(*path, key))
            for kind in ('velocity', 'acceleration', 'jerk'):
                declared = getattr(limits, f'has_{kind}_limits')
                given = getattr(limits, f'max_{kind}') is not None
                if declared and not given:
                    self._add(f"joint limits: joint '{name}' has has_{kind}_limits: true and no "
                              f'max_{kind}', self._settings.locate(*path, f'has_{kind}_limits'),
                              remedy='add it, or set has_... to false')
                elif given and declared is None:
                    self._add(f"joint limits: 'max_{kind}' of joint '{name}' has no effect "
                              f'without has_{kind}_limits: true',
                              self._settings.locate(*path, f'max_{kind}'))

    def groups_in_settings(self) -> None:
        """Check the planning groups that the other files name."""
        groups = tuple(self._model.semantic.groups)
        named: list[tuple[str, tuple[str, ...]]] = [
            ('kinematics', ('kinematics', name)) for name in self._settings.kinematics]
        pipelines = self._settings.pipelines
        named += [('planners', ('pipelines', pipeline, 'groups', name))
                  for pipeline, each in pipelines.items() for name in each.groups]
        for title, path in named:
            if path[-1] not in groups:
                self._add(f"{title}: planning group '{path[-1]}' is not in the SRDF",
                          self._settings.locate(*path), allowed=', '.join(groups),
                          remedy=nearest(path[-1], groups))
        for pipeline, each in pipelines.items():
            known = tuple(each.planner_configs)
            for name, group in each.groups.items():
                for config in (*group.planner_configs, group.default_planner_config):
                    if config and config not in known:
                        self._add(
                            f"planners of group '{name}': '{config}' is not in planner_configs",
                            self._settings.locate('pipelines', pipeline, 'groups', name),
                            allowed='' if nearest(config, known) else ', '.join(known),
                            remedy=nearest(config, known))

    def coverage(self) -> None:
        """Warn of planning groups that no controllers can move, and where there are none."""
        settings = self._settings
        if not settings.files and settings.srdf_file is None:
            self._add('there is a URDF alone: nothing can be planned and nothing moves',
                      Location(str(settings.urdf_file)),
                      remedy='make SRDF and controllers: armsim generate_config '
                             f'{settings.urdf_file} --to DIR')
            return
        if settings.spawn_only and settings.moveit_controllers and settings.srdf_file is None:
            self._add('the package has no SRDF: nothing can be planned',
                      Location(str(settings.folder)),
                      remedy='name one: srdf:=FILE, or make one: armsim generate_config URDF')
            return
        if not self._settings.moveit_controllers:
            if self._settings.controllers and self._model.semantic.groups:
                self._add('no file lists controllers for move_group: it plans, but cannot execute',
                          Location(str(self._settings.folder)),
                          remedy="add a 'controller_list' (controllers_gazebo.yaml) or "
                                 'moveit_controllers.yaml')
            return
        covered = {joint for controller in self._settings.moveit_controllers
                   for joint in controller.joints}
        for group in self._model.semantic.groups.values():
            missing = [joint for joint in self._model.controlled_joints(group.name)
                       if joint not in covered]
            if missing:
                self._add(
                    f"planning group '{group.name}' cannot be executed: no controller moves "
                    f"{', '.join(missing)}", self._places.get(f'group {group.name}'),
                    remedy='add to controller_list: ' + self._suggestion(group, missing))

    def _suggestion(self, group: PlanningGroup, missing: list[str]) -> str:
        """Return the line of YAML that would move the joints."""
        owner = next((controller.name for controller in self._settings.controllers
                      if set(missing) <= set(controller.joints)), f'{group.name}_controller')
        return (f'- {{name: {self._relative(owner)}, action_ns: follow_joint_trajectory, '
                f"type: FollowJointTrajectory, joints: [{', '.join(missing)}]}}")

    def _relative(self, controller: str) -> str:
        return f'{self._settings.namespace}/{controller}'.strip('/')

    def _check_commanded(self, title: str, joint: str, where: Location | None) -> None:
        if not self._known_joint(title, joint, where, Severity.ERROR):
            return
        found = self._model.joints[joint]
        if not found.movable:
            self._add(f"{title}: joint '{joint}' is {found.type.value} and cannot be commanded",
                      where, remedy='remove it', severity=Severity.ERROR)
        elif found.mimic is not None:
            self._add(f"{title}: joint '{joint}' follows '{found.mimic.joint}' and cannot be "
                      'commanded by itself', where, severity=Severity.ERROR,
                      remedy='remove it from the controller, or its <mimic> from the URDF')

    def _of_controller(self, joint: str) -> bool:
        """Return whether it is the joint of a following controller, ``controller/joint``."""
        owner, slash, own = joint.partition('/')
        return bool(slash) and own in self._model.joints and any(
            controller.name == owner for controller in self._settings.controllers)

    def _known_joint(self, title: str, joint: str, where: Location | None,
                     severity: Severity) -> bool:
        known = tuple(self._model.joints)
        if joint in known:
            return True
        hint = nearest(joint, self._model.movable_joints)
        self._add(f"{title}: joint '{joint}' is not in the URDF of robot '{self._model.name}'",
                  where, '' if hint else ', '.join(self._model.movable_joints), hint, severity)
        return False

    def _add(self, what: str, where: Location | None, allowed: str = '', remedy: str = '',
             severity: Severity = Severity.WARNING) -> None:
        problem = Problem(what, where, allowed, remedy, severity)
        # Of a published package what fits starts, as upstream.
        self.problems.append(ignored(problem) if self._settings.spawn_only else problem)


#: Hardware interface of a transmission -> what it lets a controller command.
_COMMANDS = {'posvel': ('position', 'velocity'),
             'posvelacc': ('position', 'velocity', 'acceleration')}


def check_description(settings: RobotSettings, content: UrdfContent) -> Iterator[Problem]:
    """Yield where controllers and URDF do not fit; each runs here all the same."""
    yield from _namespace(settings, content)
    yield from _interfaces(settings, content)


def _namespace(settings: RobotSettings, content: UrdfContent) -> Iterator[Problem]:
    if not settings.controllers:
        return
    for name, where in content.plugin_namespaces.items():
        if name != settings.namespace.strip('/'):
            yield Problem(
                f"the plugin's robotNamespace is '/{name}', the controllers run in "
                f"'{settings.namespace or '/'}'", where, '',
                f'if clients look for them in /{name}, start with namespace:={name}, or put them '
                f"below '{name}:' in their file", Severity.WARNING)


def _interfaces(settings: RobotSettings, content: UrdfContent) -> Iterator[Problem]:
    offered: dict[str, set[str]] = {}
    for transmission in content.transmissions:
        offered.setdefault(transmission.joint, set()).update(
            command for kind in transmission.interfaces
            for command in _COMMANDS.get(kind, (kind,)))
    for controller in settings.controllers:
        requested = getattr(controller.parameters, 'command_interfaces', ())
        for joint in controller.joints:
            missing = [command for command in requested
                       if command not in offered.get(joint, {command})]
            if missing:
                yield Problem(
                    f"controller '{controller.name}' commands {' and '.join(missing)} of joint "
                    f"'{joint}', whose transmission offers {' and '.join(sorted(offered[joint]))};"
                    ' ros_control would not start it, here every joint has all interfaces',
                    settings.locate('controllers', controller.name, 'joints'),
                    severity=Severity.CHANGED)
                break
