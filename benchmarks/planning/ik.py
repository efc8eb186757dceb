# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Inverse kinematics beside TRAC-IK: 3,000 random reachable poses for each robot.

Both get the same poses and the same random first guesses, in blocks that take turns. Whether a
solution is one is judged by Pinocchio's forward kinematics alone. Times are of the processor, all
threads together; so is our time limit, while TRAC-IK's own is of the wall clock: run it on a
machine that has nothing else to do.
"""

from __future__ import annotations

from dataclasses import dataclass
import json
from pathlib import Path
import re
import subprocess
import tempfile
import time
from typing import Any

import numpy as np
import pinocchio as pin

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.inverse import IKOptions, IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.loading import load_robot_model
from benchmarks.options import Options
from benchmarks.planning.planning import environment, Peer
from benchmarks.planning.problems import problem_sets

POSES = 3000
BLOCKS = 4
#: The time that each solver gets for a pose [s]: TRAC-IK's own default, and MoveIt's.
TIMEOUTS = (0.005, 0.05)
POSITION, ORIENTATION = 1e-4, 1e-3
"""What a solution may be away from its pose [m] and [rad]."""

TRAC_IK = Peer('trac_ik_solver.py', ('pytracik==0.0.3',))


@dataclass(frozen=True)
class Arm:
    """A robot for both solvers."""

    name: str
    model: KinematicModel
    group: str
    base: str
    tip: str
    urdf: Path

    def targets(self, count: int) -> list[dict[str, Any]]:
        """Return poses of random states, and other random states as first guesses."""
        rng = np.random.default_rng(1)
        index = self.model.group_indices(self.group)
        low, high = self.model.lower[index], self.model.upper[index]
        found = []
        for _ in range(count):
            state = self.model.insert(self.model.default(), self.group, rng.uniform(low, high))
            base, tip = self.model.link_poses(state, (self.base, self.tip))
            pose = np.linalg.inv(base) @ tip
            found.append({
                'position': pose[:3, 3].tolist(), 'rotation': pose[:3, :3].tolist(),
                'seed': rng.uniform(low, high).tolist(), 'pose': tip.tolist(),
            })
        return found


class Judge:
    """Says whether joint positions put the tip at a pose, within the limits."""

    def __init__(self, arm: Arm) -> None:
        self._model = pin.buildModelFromUrdf(str(arm.urdf))
        self._data = self._model.createData()
        self._tip = self._model.getFrameId(arm.tip)
        names = [arm.model.names[k] for k in arm.model.group_indices(arm.group)]
        self._order = [self._model.joints[self._model.getJointId(n)].idx_q for n in names]

    def solved(self, values: Any, pose: Any) -> bool:
        """Return whether it is a solution."""
        if values is None:
            return False
        q = pin.neutral(self._model)
        q[self._order] = values
        low = self._model.lowerPositionLimit[self._order] - 1e-6
        high = self._model.upperPositionLimit[self._order] + 1e-6
        if not (np.all(q[self._order] >= low) and np.all(q[self._order] <= high)):
            return False
        pin.framesForwardKinematics(self._model, self._data, q)
        reached, wanted = self._data.oMf[self._tip], np.array(pose)
        off = np.linalg.norm(reached.translation - wanted[:3, 3])
        turned = np.linalg.norm(pin.log3(reached.rotation.T @ wanted[:3, :3]))
        return bool(off <= POSITION and turned <= ORIENTATION)


def arms(folder: Path) -> list[Arm]:
    """Return the robots."""
    panda = next(each.folder for each in problem_sets('', 1) if 'panda' in each.robot)
    found = []
    for name, source in (('sunday', 'sunday'), ('ur5', 'ur5'), ('panda', str(panda))):
        robot = load_robot_model(load_robot_settings(source))
        group, chain = max(
            robot.semantic.groups.items(), key=lambda item: len(item[1].active_joints))
        urdf = folder / f'{name}.urdf'
        # TRAC-IK takes the soft limits of ROS 1's safety controllers for 0.
        text = re.sub(r'<safety_controller[^>]*/>', '', robot.urdf)
        urdf.write_text(text, encoding='utf-8')
        first = robot.joints[chain.active_joints[0]]
        tip = chain.tips[-1] if chain.tips else chain.links[-1]
        found.append(Arm(name, KinematicModel(robot), group, first.parent, tip, urdf))
    return found


def ours(arm: Arm, targets: list[dict[str, Any]], timeout: float) -> list[dict[str, Any]]:
    """Return this package's answers."""
    solver = InverseKinematics(arm.model, arm.group)
    rng = np.random.default_rng(2)
    answers = []
    for target in [targets[0], *targets]:
        seed = arm.model.insert(arm.model.default(), arm.group, target['seed'])
        wanted = [IKTarget(arm.tip, np.array(target['pose']))]
        began = time.thread_time()
        result = solver.solve(wanted, seed, IKOptions(
            rng=rng, clock=time.thread_time, deadline=began + timeout))
        seconds = time.thread_time() - began
        values = None if result.q is None else arm.model.extract(result.q, arm.group)
        answers.append({'values': values, 'seconds': seconds})
    return answers[1:]


def theirs(
    python: str, arm: Arm, targets: list[dict[str, Any]], timeout: float
) -> list[dict[str, Any]]:
    """Return TRAC-IK's answers."""
    question = {
        'urdf': str(arm.urdf), 'base': arm.base, 'tip': arm.tip, 'timeout': timeout,
        'targets': targets,
    }
    script = Path(__file__).parent / 'peers' / TRAC_IK.script
    made = subprocess.run(
        [python, str(script)], input=json.dumps(question) + '\n', capture_output=True,
        text=True, check=True,
    )
    answers: list[dict[str, Any]] = json.loads(made.stdout)['answers']
    return answers


def main(options: Options) -> None:
    """Solve for every robot; print success and times."""
    python = environment('trac_ik', TRAC_IK)
    print('| Robot | Time for a pose | Solver | Solved | p50 | p95 | p99 |\n'
          '|---|---|---|---|---|---|---|')
    with tempfile.TemporaryDirectory() as folder:
        for arm in arms(Path(folder)):
            targets, judge = arm.targets(POSES), Judge(arm)
            for timeout in TIMEOUTS:
                results: dict[str, list[dict[str, Any]]] = {'armsim_ros': [], 'TRAC-IK': []}
                for block in range(BLOCKS):
                    part = targets[block::BLOCKS]
                    results['armsim_ros'] += ours(arm, part, timeout)
                    if python is not None:
                        results['TRAC-IK'] += theirs(python, arm, part, timeout)
                order = [target for block in range(BLOCKS) for target in targets[block::BLOCKS]]
                for name, answers in results.items():
                    if answers:
                        print(row(arm.name, timeout, name, answers, order, judge), flush=True)


def row(
    robot: str, timeout: float, name: str, answers: list[dict[str, Any]],
    targets: list[dict[str, Any]], judge: Judge
) -> str:
    """Return a line of the table."""
    solved = sum(
        judge.solved(answer['values'], target['pose'])
        for answer, target in zip(answers, targets, strict=True))
    times = [answer['seconds'] * 1e3 for answer in answers]
    p50, p95, p99 = np.quantile(times, (0.5, 0.95, 0.99))
    return (f'| {robot} | {timeout * 1e3:.0f} ms | {name} | {solved / len(answers):.2%} | '
            f'{p50:.2f} ms | {p95:.2f} ms | {p99:.2f} ms |')
