# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rate and stamps of /sunday/joint_states, lateness of the control tick, idle and planning."""

from __future__ import annotations

import itertools
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray
from moveit_msgs.msg import Constraints, JointConstraint
from moveit_msgs.srv import GetMotionPlan
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from benchmarks.options import Options
from benchmarks.stack import percentile, running_stack, Stack

LATENESS = ('lateness_p50_us', 'lateness_p99_us', 'lateness_max_us')


def main(options: Options) -> None:
    """Print rate and lateness of two phases: nothing to do, and plans without pause."""
    with running_stack() as stack:
        measure(stack, 'idle', options.seconds)
        stop = threading.Event()
        planner = threading.Thread(target=plan_without_pause, args=(stack, stop))
        planner.start()
        try:
            measure(stack, 'planning without pause', options.seconds)
        finally:
            stop.set()
            planner.join()


def measure(stack: Stack, phase: str, seconds: float) -> None:
    """Collect for a while and print."""
    states = stack.client.collect('/sunday/joint_states', JointState, 100)
    diagnostics = stack.client.collect('/diagnostics', DiagnosticArray, qos_profile_sensor_data)
    time.sleep(seconds)
    states.close()
    diagnostics.close()
    stamps = [m.header.stamp.sec * 1_000_000_000 + m.header.stamp.nanosec for m in states.messages]
    steps = [(later - earlier) * 1e-6 for earlier, later in itertools.pairwise(stamps)]
    rate = (len(stamps) - 1) / ((stamps[-1] - stamps[0]) * 1e-9)
    print(f'{phase}: {len(stamps)} joint states in {seconds:.0f} s, {rate:.3f} Hz, '
          f'step p50 {percentile(steps, 0.5):.2f} ms, p99 {percentile(steps, 0.99):.2f} ms, '
          f'strictly increasing: {all(step > 0.0 for step in steps)}')
    values = {
        item.key: item.value
        for message in diagnostics.messages[-1:]
        for status in message.status
        for item in status.values}
    lateness = ', '.join(f'{key} {values.get(key, "?")}' for key in LATENESS)
    print(f'  control tick: {lateness}; priority {values.get("priority", "?")}, '
          f'real-time factor {values.get("real_time_factor", "?")}')


def plan_without_pause(stack: Stack, stop: threading.Event) -> None:
    """Ask for one plan after the other."""
    count = 0
    while not stop.is_set():
        request = GetMotionPlan.Request()
        plan = request.motion_plan_request
        plan.group_name = 'manipulator'
        plan.allowed_planning_time = 5.0
        plan.start_state.is_diff = True
        angles = (0.5, 0.5, 0.5, -0.5, 1.5, 0.0) if count % 2 else (-0.8, 0.2, 1.0, 0.9, 0.3, 1.0)
        plan.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(joint_name=f'joint_{i + 1}', position=angle, weight=1.0)
            for i, angle in enumerate(angles)])]
        stack.client.call('/plan_kinematic_path', GetMotionPlan, request, 30.0)
        count += 1
    print(f'  ({count} plans)')
