# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Quality of service: options, profiles, and what fits the publishers of a topic."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from copy import copy
import sys
from typing import Any

from armsim_ros2.parsing import Arguments, Parser

_PROFILES = ('unknown', 'default', 'system_default', 'sensor_data', 'services_default',
             'parameters', 'parameter_events', 'action_status_default', 'best_available')
_CHOICES = {
    'history': ('system_default', 'keep_last', 'keep_all', 'unknown'),
    'reliability': ('system_default', 'reliable', 'best_effort', 'unknown', 'best_available'),
    'durability': ('system_default', 'transient_local', 'volatile', 'unknown', 'best_available'),
    'liveliness': ('system_default', 'automatic', 'manual_by_topic', 'unknown', 'best_available'),
}

#: What rosbag2 compares: all but history and lifespan.
_REQUESTED = ('reliability', 'durability', 'deadline', 'liveliness', 'liveliness_lease_duration')


def qos_options(default: str) -> Arguments:
    """
    Return a function that adds the options.

    :param default: name of the profile that they change.
    """
    def add(parser: Parser) -> None:
        parser.add_argument('--qos-profile', choices=_PROFILES, default=default,
                            help='profile to begin with (default: %(default)s)')
        parser.add_argument('--qos-depth', type=int, metavar='N', help='length of the queue')
        for name, choices in _CHOICES.items():
            parser.add_argument(f'--qos-{name}', choices=choices, help=f'{name} of the profile')
        parser.add_argument('--qos-liveliness-lease-duration-seconds', type=float, metavar='S',
                            help='lease of the liveliness')

    return add


def profile_of(options: Namespace) -> Any:
    """Return the profile that the options describe."""
    from rclpy import qos
    from rclpy.duration import Duration

    profile = copy(qos.QoSPresetProfiles.get_from_short_key(options.qos_profile))
    for name in _CHOICES:
        key = getattr(options, f'qos_{name}')
        if key:
            policy = getattr(qos, f'QoS{name.capitalize()}Policy')
            setattr(profile, name, policy.get_from_short_key(key))
    lease = options.qos_liveliness_lease_duration_seconds
    if lease is not None and lease >= 0:
        profile.liveliness_lease_duration = Duration(seconds=lease)
    if options.qos_depth is not None and options.qos_depth >= 0:
        profile.depth = options.qos_depth
    elif profile.durability == qos.QoSDurabilityPolicy.TRANSIENT_LOCAL and profile.depth == 0:
        profile.depth = 1
    return profile


def compatible_profile(options: Namespace, publishers: list[Any]) -> Any:
    """
    Return the profile of the options, completed to one that all publishers match.

    :param publishers: what the graph reports about the publishers of the topic.
    """
    given = [options.qos_depth, options.qos_liveliness_lease_duration_seconds,
             *(getattr(options, f'qos_{name}') for name in _CHOICES)]
    profile = profile_of(options)
    if not publishers or any(value is not None for value in given):
        return profile
    return matched(profile, publishers)


def matched(profile: Any, publishers: list[Any]) -> Any:
    """
    Return a profile after setting what all publishers of a topic match.

    :param publishers: what the graph reports about them.
    """
    from rclpy.qos import QoSDurabilityPolicy, QoSReliabilityPolicy

    for name, strong, weak in (
            ('reliability', QoSReliabilityPolicy.RELIABLE, QoSReliabilityPolicy.BEST_EFFORT),
            ('durability', QoSDurabilityPolicy.TRANSIENT_LOCAL, QoSDurabilityPolicy.VOLATILE)):
        offers = [getattr(info.qos_profile, name) == strong for info in publishers]
        if any(offers) and not all(offers):
            kind = type(strong).__name__
            print(f'Some, but not all, publishers are offering {kind}.{strong.name}. Falling back '
                  f'to {kind}.{weak.name} as it will connect to all publishers')
        setattr(profile, name, strong if all(offers) else weak)
    return profile


def to_plain(profile: Any) -> dict[str, Any]:
    """Return a profile as rosbag2 writes it (version 9 of its metadata)."""
    def span(duration: Any) -> dict[str, int]:
        seconds, rest = divmod(duration.nanoseconds, 1_000_000_000)
        return {'sec': seconds, 'nsec': rest}

    return {
        'history': profile.history.short_key, 'depth': profile.depth,
        'reliability': profile.reliability.short_key, 'durability': profile.durability.short_key,
        'deadline': span(profile.deadline), 'lifespan': span(profile.lifespan),
        'liveliness': profile.liveliness.short_key,
        'liveliness_lease_duration': span(profile.liveliness_lease_duration),
        'avoid_ros_namespace_conventions': profile.avoid_ros_namespace_conventions,
    }


def offered(topic: str, recorded: Sequence[Mapping[str, Any]]) -> Any:
    """
    Return the profile to publish a recorded topic with.

    :param recorded: those of its publishers as rosbag2 writes them; earlier versions have numbers
        for policies.
    :returns: the default if they differ in what subscriptions may request.
    """
    from rclpy import qos

    profile = qos.QoSProfile(depth=10)
    if not recorded:
        return profile
    values = recorded[0]
    if any(other.get(name) != values.get(name) for other in recorded for name in _REQUESTED):
        print(f'Not all original publishers on topic {topic} offered the same QoS profiles. '
              'Falling back to the default', file=sys.stderr)
        return profile
    for name in ('reliability', 'durability'):
        policy, value = getattr(qos, f'QoS{name.capitalize()}Policy'), values[name]
        setattr(profile, name, policy(value) if isinstance(value, int)
                else policy.get_from_short_key(value))
    return profile
