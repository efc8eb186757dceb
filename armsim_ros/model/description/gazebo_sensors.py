# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors that a URDF declares for Gazebo: where they are."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
import math

from armsim_ros.model.description.xml_tree import TextReport, XmlElement
from armsim_ros.model.robot_model import HardwareSensor, Joint


@dataclass(frozen=True)
class GazeboSensor:
    """
    A sensor that is declared for Gazebo.

    :param link: on which it sits.
    """

    element: XmlElement
    link: str


def gazebo_sensors(root: XmlElement, links: Collection[str], joints: Mapping[str, Joint]
                   ) -> dict[str, GazeboSensor]:
    """
    Return name -> sensor, of all that are on a link or joint.

    :param root: of a URDF.
    :param links: of the URDF, ``joints`` likewise.
    """
    found = {}
    for element in root.all('gazebo'):
        place = element.get('reference')
        link = joints[place].child if place in joints else place
        if link in links:
            found.update({sensor.get('name'): GazeboSensor(sensor, link)
                          for sensor in element.all('sensor')})
    return found


def mounted(sensor: HardwareSensor, gazebo: Mapping[str, GazeboSensor], report: TextReport
            ) -> HardwareSensor:
    """Return a sensor with the ``<pose>`` that Gazebo's sensor of its name has in its link."""
    known = gazebo.get(sensor.name)
    pose = known.element.first('pose') if known is not None else None
    if known is None or pose is None or known.link != sensor.frame:
        return sensor
    try:
        mount = [float(word) for word in pose.content.split()]
    except ValueError:
        mount = []
    if (len(mount) != 6 or not all(map(math.isfinite, mount))
            or pose.get('rotation_format', 'euler_rpy') != 'euler_rpy'
            or pose.get('relative_to') not in ('', sensor.frame)):
        report.ignored(f"sensor '{sensor.name}' measures at the origin of '{sensor.frame}': its "
                       '<pose> is not x, y, z, roll, pitch, yaw in its link', pose.where)
        return sensor
    if pose.get('degrees').lower() in ('true', '1'):
        mount[3:] = map(math.radians, mount[3:])
    return replace(sensor, mount=tuple(mount))
