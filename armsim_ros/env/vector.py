# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several environments at once, each in a process of its own; needs no Gymnasium."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.env.arm_env import ArmEnv
from armsim_ros.errors import ArmsimError

MakeEnv = Callable[[], ArmEnv]
Observations = dict[str, Matrix]


class ProcessVector:
    """
    Environments that reset and step together.

    An environment whose episode has ended resets at the next step, whose action it does not use,
    as Gymnasium's vector environments do.

    :param makers: each makes an environment in its process; functions of a module, or
        ``functools.partial`` of such.
    :raises ArmsimError: an environment cannot be made.
    """

    def __init__(self, makers: Sequence[MakeEnv]) -> None:
        context = get_context('spawn')  # a copy of this process would share its threads' locks
        self._pipes: list[Connection] = []
        self._processes = []
        for maker in makers:
            ours, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, maker), daemon=True)
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)
        try:
            self._answers()
        except ArmsimError:
            self.close()
            raise

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._pipes)

    def reset(self, *, seed: int | None = None) -> Observations:
        """
        Begin episodes.

        :param seed: of the first environment; the next has the next number. None goes on.
        :returns: observations (k, n), a row for each environment.
        """
        seeds = [None if seed is None else seed + place for place in range(len(self))]
        answers = self._ask('reset', [{'seed': number} for number in seeds])
        return _stacked([observation for observation, _ in answers])

    def step(self, actions: Matrix) -> tuple[Observations, Matrix, Matrix, Matrix]:
        """
        Do a step in each environment.

        :param actions: (k, m).
        :returns: observations, and (k,) rewards, whether terminated, whether truncated.
        :raises ArmsimError: an environment cannot do it.
        """
        answers = self._ask('step', [{'action': action} for action in actions])
        observations, rewards, terminated, truncated, _ = zip(*answers, strict=True)
        return (_stacked(observations), np.array(rewards), np.array(terminated),
                np.array(truncated))

    def digests(self) -> list[str]:
        """Return the digest of each."""
        return self._ask('digest', [{}] * len(self))

    def close(self) -> None:
        """End the processes."""
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.join()

    def _ask(self, method: str, words: Sequence[dict[str, Any]]) -> list[Any]:
        for pipe, arguments in zip(self._pipes, words, strict=True):
            with suppress(BrokenPipeError):  # it has ended; its answer will report that
                pipe.send((method, arguments))
        return self._answers()

    def _answers(self) -> list[Any]:
        answers = []
        for place, pipe in enumerate(self._pipes):
            try:
                answers.append(pipe.recv())
            except EOFError:
                process = self._processes[place]
                process.join()
                answers.append(ArmsimError(f'its process has ended (status {process.exitcode})'))
        for place, answer in enumerate(answers):
            if isinstance(answer, ArmsimError):
                raise ArmsimError(f'environment {place}: {answer}')
        return answers

    def __enter__(self) -> ProcessVector:
        """Return the environments."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes."""
        self.close()


def _serve(pipe: Connection, maker: MakeEnv) -> None:
    """Run an environment until the other end of the pipe is closed."""
    ended = False
    try:
        env = maker()
        pipe.send(None)
        while True:
            method, words = pipe.recv()
            try:
                if method == 'step' and ended:
                    answer: Any = (env.reset()[0], 0.0, False, False, {})
                else:
                    answer = getattr(env, method)(**words)
            except ArmsimError as error:
                answer = ArmsimError(str(error))
            else:
                if method != 'digest':
                    ended = method == 'step' and (answer[2] or answer[3])
            pipe.send(answer)
    except ArmsimError as error:
        pipe.send(ArmsimError(str(error)))
    except (EOFError, BrokenPipeError, KeyboardInterrupt):
        return


def _stacked(observations: Sequence[dict[str, Matrix]]) -> Observations:
    return {name: np.stack([observation[name] for observation in observations])
            for name in observations[0]}
