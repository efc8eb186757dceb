# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Wall time that passes only by sleeping, for loops that keep a pace."""

from armsim_ros.sim.pacer import Pacer


class InventedClock:
    """Time that passes only by sleeping; it counts how often somebody does."""

    now = 0
    naps = 0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.naps += 1
        self.now += round(seconds * 1e9)


class InventedAlarm:
    """An alarm that goes off at a time of the invented clock, if at all."""

    def __init__(self, clock):
        self.clock, self.at = clock, None
        self.on_nap = lambda: None

    def wait(self, timeout):
        self.clock.naps += 1
        self.on_nap()
        end = self.clock.now + round(timeout * 1e9)
        goes_off = self.at is not None and self.at <= end
        self.clock.now = max(self.clock.now, self.at) if goes_off else end
        return goes_off

    def set(self):
        self.at = self.clock.now

    def clear(self):
        if self.at is not None and self.at <= self.clock.now:
            self.at = None


def invented_pacer():
    """Return a pacer of invented time, its clock and its alarm."""
    clock = InventedClock()
    alarm = InventedAlarm(clock)
    return Pacer(clock=clock, sleep=clock.sleep, alarm=alarm), clock, alarm
