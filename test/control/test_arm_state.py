# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Drives and safety of an arm, in invented time."""


from armsim_ros.config.simulation import HardwareSettings
from armsim_ros.control.arm_state import ArmState, Cause, Mode, Safety
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.vendors import Vendor

SECOND = 1_000_000_000


def arm_of(**table):
    """Return the arm of a vendor."""
    vendor = Vendor(name='test', **table)
    return ArmState(HardwareSettings(), vendor, EventQueue('arm'), lambda: None)


def test_a_protective_stop_lasts_for_the_vendors_delay():
    """HW-B4: It is not cleared before, and the text names the delay."""
    arm = arm_of(unlock_delay=5.0)
    arm.protective_stop()
    arm.update(4 * SECOND)
    assert 'wait 1.0 s' in arm.clear_stop()
    assert arm.safety is Safety.PROTECTIVE_STOP
    arm.update(5 * SECOND)
    assert arm.clear_stop() == ''
    assert arm.moves


def test_a_cause_that_is_still_there_keeps_the_stop():
    """HW-B4: An arm that is still pressed cannot be cleared."""
    arm = arm_of()
    arm.protective_stop(Cause('collision', 'pressed'))
    arm.present_cause = lambda: Cause('collision', 'pressed')
    assert arm.clear_stop() == 'the cause is still there: collision: pressed'
    arm.present_cause = lambda: None
    assert arm.clear_stop() == ''


def test_the_drives_are_powered_step_by_step():
    """HW-A1, HW-C4: Each mode on the way lasts for the vendor's time."""
    arm = arm_of(power_step=1.0)
    arm.power_to(Mode.POWER_OFF)
    arm.power_to(Mode.RUNNING)
    seen = [arm.mode]
    for second in range(1, 4):
        arm.update(second * SECOND)
        seen.append(arm.mode)
    assert seen == [Mode.POWER_OFF, Mode.POWER_ON, Mode.IDLE, Mode.RUNNING]


def test_a_released_emergency_stop_can_leave_the_drives_off():
    """HW-B4: The arm does not go on by itself."""
    arm = arm_of(emergency_power_off=True)
    arm.emergency_stop()
    arm.release_emergency_stop()
    assert (arm.safety, arm.mode) == (Safety.NORMAL, Mode.POWER_OFF)
    assert arm.obstacle
