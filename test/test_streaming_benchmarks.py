# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The benchmarks of streaming that need no ROS, with a few of what they do a thousand times."""

from armsim_ros.sim.drives.reference import VELOCITY_HEADROOM
from benchmarks.streaming.streaming_jogs import jogs_table
from benchmarks.streaming.streaming_switches import switches_table
from benchmarks.streaming.streaming_two_arms import pairs_table


def test_jogs_among_obstacles_touch_nothing():
    """Neither a contact of the physics nor a limit that is passed."""
    figures = dict(jogs_table(4, 1).rows)
    assert figures['contacts'] == '0'
    assert figures['past the limit of a joint'] == '0.0000 rad'


def test_switches_with_motion_make_no_step():
    """No reference moves faster than the drive's limit, and every goal ends with a reason."""
    figures = dict(switches_table(60, 2).rows)
    share = figures['largest step of the reference, share of the velocity limit']
    assert float(share.removesuffix(' %')) <= 100.0 * VELOCITY_HEADROOM
    assert figures['goals without an end'] == '0'
    assert figures['goals that ended without a reason'] == '0'


def test_two_arms_at_once_do_not_meet():
    """Motions at once take no longer than the longer one, and never meet."""
    figures = dict(pairs_table(2, 3).rows)
    assert figures['pairs in which the arms met, as commanded, on their own shapes'] == '0'
    assert figures['pairs'] == '2'
