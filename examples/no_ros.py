# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Plan to a named state and run the motion, without ROS and without a wall clock.

Every run prints the same digest: simulated time moves only by steps, and the planner's random
numbers come from the seed.

    python examples/no_ros.py scan_food
"""

import argparse
import sys

from armsim_ros import ArmSim, ArmsimError


def run(robot: str, state: str, seed: int) -> None:
    """Plan, execute and print what happened."""
    sim = ArmSim(robot, seed=seed)
    trajectory = sim.plan(state)
    print(f'planned {len(trajectory)} points, {trajectory.duration:.3f} s')
    sim.execute(trajectory)
    print(f'executed; simulated time is {sim.time:.3f} s')
    goal = dict(zip(trajectory.joint_names, trajectory.positions[-1], strict=True))
    for name, position in goal.items():
        error = sim.joint_positions[name] - position
        print(f'  {name}: {sim.joint_positions[name]:+.4f} rad, error {error:+.1e}')
    print(f'digest {sim.digest()}')


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description='Plan and execute without ROS.')
    parser.add_argument('state', nargs='?', default='scan_food', help='named state of the SRDF')
    parser.add_argument('--robot', default='sunday', help='name or folder of the robot')
    parser.add_argument('--seed', type=int, default=0, help="seed of the planner's choices")
    arguments = parser.parse_args()
    try:
        run(arguments.robot, arguments.state, arguments.seed)
    except ArmsimError as error:
        sys.exit(f'no_ros: {error}')


if __name__ == '__main__':
    main()
