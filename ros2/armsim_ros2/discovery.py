# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a new node learns what is in the graph, and when it knows all of it."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import time
from typing import Any

_PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
#: How often the graph is read [s].
_PERIOD = 0.02
#: Discovery is complete when nothing new has come for so many periods.
_QUIET = 5
#: Fewest periods where programs of other machines are discovered: they announce themselves again
#: after 0.3 s if their first answer was lost.
_LEAST_SUBNET = 16
#: How many periods more discovery may take while programs are known to be missing: the middleware
#: sends again every second what was lost.
_LATE = 60
#: Each participant has one writer of this topic.
_PARTICIPANTS = 'ros_discovery_info'


def announce_often() -> bool:
    """
    Let Fast DDS announce this process often and send by sockets; a user's own settings are kept.

    :returns: whether nodes are discovered quickly.
    """
    chosen = [os.environ[name] for name in _PROFILES if os.environ.get(name)]
    if chosen:
        return Path(chosen[0]).name == 'fastdds_profiles.xml'
    if Path('DEFAULT_FASTRTPS_PROFILES.xml').is_file():
        return False
    os.environ[_PROFILES[0]] = str(Path(__file__).with_name('fastdds_profiles.xml'))
    os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    return True


def settle(node: Any, spin_time: float) -> None:
    """
    Wait until discovery brings nothing new.

    Longer than the spin time only while programs of this machine are known to be missing. Periods
    are counted instead of seconds: a machine that delays this process delays discovery, too.

    :param spin_time: longest time [s].
    """
    local = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE') == 'LOCALHOST'
    least, most = 0 if local else _LEAST_SUBNET, round(spin_time / _PERIOD)
    last, quiet = _sizes(node), 0
    for period in range(most + _LATE):
        enough = quiet >= _QUIET and period >= least
        if (enough or period >= most) and _is_complete(node):
            return
        time.sleep(_PERIOD)
        sizes = _sizes(node)
        quiet = quiet + 1 if sizes == last and sizes[0] > 1 else 0
        last = sizes


def _sizes(node: Any) -> tuple[int, int, int]:
    return (len(node.get_node_names()), len(node.get_topic_names_and_types()),
            len(node.get_service_names_and_types()))


def _is_complete(node: Any) -> bool:
    """Return whether all programs of this machine are known, each with its nodes and servers."""
    from rclpy.node import NodeNameNonExistentError

    # Each node publishes its changes of parameters.
    publishers = node.get_publishers_info_by_topic('/parameter_events')
    programs = node.get_publishers_info_by_topic(_PARTICIPANTS, no_mangle=True)
    try:
        return (len(programs) >= local_programs(node.context.get_domain_id())
                and _participants(programs) <= _participants(publishers)
                and not any(info.node_name == '_NODE_NAME_UNKNOWN_' for info in publishers)
                and all(node.get_publisher_names_and_types_by_node(*names)
                        for names in node.get_node_names_and_namespaces())
                and all(_has_both_halves(node, service)
                        for service, _ in node.get_service_names_and_types()))
    except NodeNameNonExistentError:
        return False


def _participants(endpoints: Sequence[Any]) -> set[bytes]:
    """Return the participants of endpoints: the first twelve bytes of their GUIDs."""
    return {bytes(info.endpoint_gid[:12]) for info in endpoints}


def _has_both_halves(node: Any, service: str) -> bool:
    """
    Return whether both endpoints of a service's servers are known.

    Subscriptions and publishers of a program arrive separately; either may be delayed.
    """
    readers = node.get_subscriptions_info_by_topic(f'rq{service}Request', no_mangle=True)
    writers = node.get_publishers_info_by_topic(f'rr{service}Reply', no_mangle=True)
    return len(readers) == len(writers)


def local_programs(domain: int) -> int:
    """
    Return how many participants of a domain this machine has.

    Each is bound to the first port that is free of those for its kind of traffic (Real-Time
    Publish-Subscribe Protocol 2.5, section 9.6.2.4). Unknown, and so 0, where there is no /proc.
    """
    first = 7400 + 250 * domain + 10
    ports = set(range(first, first + 240, 2))
    table = Path('/proc/net/udp')
    rows = table.read_text().splitlines()[1:] if table.is_file() else ()
    return len(ports & {int(row.split()[1].partition(':')[2], 16) for row in rows})
