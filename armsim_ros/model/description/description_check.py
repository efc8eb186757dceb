# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the settings fit a URDF's data for Gazebo: motors, and the plugin's namespace."""

from __future__ import annotations

from collections.abc import Iterator

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import Problem, Severity
from armsim_ros.model.description.urdf import UrdfContent

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
        wanted = getattr(controller.parameters, 'command_interfaces', ())
        for joint in controller.joints:
            missing = [command for command in wanted
                       if command not in offered.get(joint, {command})]
            if missing:
                yield Problem(
                    f"controller '{controller.name}' commands {' and '.join(missing)} of joint "
                    f"'{joint}', whose transmission offers {' and '.join(sorted(offered[joint]))};"
                    ' ros_control would not start it, here every joint has all interfaces',
                    settings.locate('controllers', controller.name, 'joints'),
                    severity=Severity.CHANGED)
                break
