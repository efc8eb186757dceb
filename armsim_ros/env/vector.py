# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many environments at once, on all processors: a Gymnasium vector environment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
import os
from selectors import DefaultSelector, EVENT_READ
from traceback import format_exception
from typing import Any

from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate
import numpy as np
from numpy.typing import NDArray

from armsim_ros.env.arm_env import ArmEnv
from armsim_ros.env.options import checked_choices
from armsim_ros.errors import ArmsimError, ConfigError, Problem

MakeEnv = Callable[[], ArmEnv]
#: Between two checks whether a worker is still alive [s].
_CHECK_S = 1.0


class ArmVectorEnv(VectorEnv[Any, Any, Any]):
    """
    Environments in a few processes; each process steps its share one by one.

    This process has a share, too: it would only wait, and a process that sleeps takes long to
    wake. A row equals what a single environment with its seed gives, to the bit.

    :param make: makes an environment; a function of a module, or ``functools.partial`` of such.
    :param num_envs: how many.
    :param autoreset_mode: what a step after the end of an episode does, as of Gymnasium:
        ``NextStep``, ``SameStep`` or ``Disabled``.
    :param workers: processes, with this one; by default one per processor, at most one per
        environment.
    :raises ArmsimError: an environment cannot be made.
    """

    def __init__(
        self, make: MakeEnv, num_envs: int = 1, *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP, workers: int = 0
    ) -> None:
        if num_envs < 1:
            raise ConfigError(Problem(f'num_envs={num_envs}', allowed='at least 1'))
        names = tuple(mode.value for mode in AutoresetMode)
        mode = (autoreset_mode.value if isinstance(autoreset_mode, AutoresetMode)
                else autoreset_mode)
        checked_choices({'autoreset_mode': (mode, names)})
        workers = min(workers or len(os.sched_getaffinity(0)), num_envs)
        context = get_context('spawn')  # a copy of this process would share its threads' locks
        self.num_envs = num_envs
        self._shares = [range(num_envs)[begin::workers] for begin in range(workers)]
        self._pipes: list[Connection] = []
        self._processes: list[Any] = []
        #: Of each process: waits for its answer, or its end.
        self._selectors: list[DefaultSelector] = []
        for share in self._shares[1:]:
            ours, theirs = context.Pipe()
            process = context.Process(
                target=_serve, args=(theirs, make, len(share), mode), daemon=True)
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)
            self._selectors.append(DefaultSelector())
            for event in (ours, process.sentinel):
                self._selectors[-1].register(event, EVENT_READ)
        self._own = _Share(make, len(self._shares[0]), mode)
        #: Whether answers are awaited; it stays so where a call was interrupted.
        self._pending = True
        try:
            facts = self._answers(self._own.begin())[0]
        except BaseException:
            self.close()
            raise
        self.single_observation_space, self.single_action_space = facts[:2]
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {**facts[2], 'autoreset_mode': AutoresetMode(mode)}
        self.render_mode = facts[3]

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """
        Begin episodes.

        :param seed: of the first environment, the next has the next number; or one for each.
        :param options: of all; ``reset_mask`` (n,) names those that begin.
        :returns: observations (n, ...), and infos.
        :raises ArmsimError: an environment cannot do it.
        """
        if seed is None or isinstance(seed, int):
            seeds = [None if seed is None else seed + place for place in range(self.num_envs)]
        else:
            seeds = list(seed)
        options = dict(options or {})
        mask = options.pop('reset_mask', np.ones(self.num_envs, dtype=np.bool_))
        rows = self._scattered('reset', [
            (seeds[place], options, bool(mask[place])) for place in range(self.num_envs)])
        observations, infos = zip(*rows, strict=True)
        return self._stacked(observations), self._infos(infos)

    def step(
        self, actions: Any
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """
        Do a step in each environment.

        :param actions: (n, m).
        :returns: observations, and (n,) rewards, whether terminated, whether truncated; infos.
        :raises ArmsimError: an environment cannot do it.
        """
        rows = self._scattered('step', list(iterate(self.action_space, actions)))
        observations, rewards, terminated, truncated, infos = zip(*rows, strict=True)
        return (self._stacked(observations), np.array(rewards, dtype=np.float64),
                np.array(terminated, dtype=np.bool_), np.array(truncated, dtype=np.bool_),
                self._infos(infos))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Return an attribute of each environment, or what a call of it returns."""
        return tuple(self._scattered('call', [(name, args, kwargs)] * self.num_envs))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of each environment."""
        return self.call(name)

    def render(self) -> tuple[Any, ...] | None:
        """Return a picture of each environment."""
        return self.call('render')

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments and end the processes."""
        self._own.close()
        for selector, pipe in zip(self._selectors, self._pipes, strict=True):
            selector.close()
            pipe.close()
        for process in self._processes:
            process.join()

    def _stacked(self, rows: Sequence[Any]) -> Any:
        space = self.single_observation_space
        empty: Any = create_empty_array(space, self.num_envs, fn=np.empty)
        return concatenate(space, rows, empty)

    def _infos(self, infos: Sequence[dict[str, Any]]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for place, info in enumerate(infos):
            found = self._add_info(found, info, place)
        return found

    def _scattered(self, method: str, arguments: Sequence[Any]) -> list[Any]:
        """Return what each environment answers, in their order."""
        if self._pending:
            raise ArmsimError('an earlier call was interrupted, so that the environments are at '
                              'different steps; close this vector and make a new one')
        parts = [[arguments[place] for place in share] for share in self._shares]
        messages = [ForkingPickler.dumps((method, part)) for part in parts[1:]]
        self._pending = True
        for message, pipe in zip(messages, self._pipes, strict=True):
            with suppress(BrokenPipeError):  # it has ended; its answer will report that
                pipe.send_bytes(message)
        rows: list[Any] = [None] * self.num_envs
        answered = self._answers(self._own.do(method, parts[0]))
        for share, answers in zip(self._shares, answered, strict=True):
            for place, answer in zip(share, answers, strict=True):
                rows[place] = answer
        return rows

    def _answers(self, own: Any) -> list[Any]:
        """Return the answer of each process; raise what is wrong only when all have answered."""
        answers: list[Any] = []
        failures = []
        for number in range(len(self._shares)):
            answer = self._received(number - 1) if number else own
            if isinstance(answer, _Failure):
                place = self._shares[number][answer.place]
                failures.append(f'environment {place}: {answer.text}')
            answers.append(answer)
        self._pending = False
        if failures:
            raise ArmsimError(failures[0])
        return answers

    def _received(self, number: int) -> Any:
        process, pipe = self._processes[number], self._pipes[number]
        while True:
            try:
                if self._selectors[number].select(_CHECK_S):
                    return pipe.recv()
            except (EOFError, ConnectionResetError):
                process.join()
                return _Failure(0, ArmsimError(
                    f'its process has ended (status {process.exitcode})'))


class _Failure:
    """
    What a process could not do.

    :param place: which of its environments could not.
    :param error: why; an error of the environment's own code is kept with its traceback.
    """

    def __init__(self, place: int, error: Exception) -> None:
        expected = isinstance(error, (ArmsimError, ValueError))
        self.place = place
        self.text = str(error) if expected else ''.join(format_exception(error)).rstrip()


class _Row:
    """An environment of a process, with its autoreset."""

    def __init__(self, env: ArmEnv, mode: str) -> None:
        self._env, self._mode = env, mode
        self._ended = False
        self._last: Any = None

    def reset(self, arguments: tuple[int | None, dict[str, Any], bool]) -> tuple[Any, Any]:
        seed, options, begins = arguments
        if not begins and self._last is not None:
            return self._last, {}
        return self._begun(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self._ended and self._mode == AutoresetMode.NEXT_STEP.value:
            observation, info = self._begun()
            return observation, 0.0, False, False, info
        observation, reward, terminated, truncated, info = self._env.step(action)
        self._last, self._ended = observation, terminated or truncated
        if self._ended and self._mode == AutoresetMode.SAME_STEP.value:
            last, final = observation, info
            observation, info = self._begun()
            info = {**info, 'final_obs': last, 'final_info': final}
        return observation, reward, terminated, truncated, info

    def call(self, arguments: tuple[str, Any, Any]) -> Any:
        name, args, kwargs = arguments
        found = getattr(self._env, name)
        return found(*args, **kwargs) if callable(found) else found

    def _begun(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        observation, info = self._env.reset(**arguments)
        self._last, self._ended = observation, False
        return observation, info


class _Share:
    """The environments of a process."""

    def __init__(self, make: MakeEnv, count: int, mode: str) -> None:
        self._make, self._count, self._mode = make, count, mode
        self._envs: list[ArmEnv] = []

    def begin(self) -> tuple[Any, ...] | _Failure:
        """Make the environments; return spaces, metadata and render mode, or what failed."""
        try:
            while len(self._envs) < self._count:
                self._envs.append(self._make())
        except Exception as error:  # noqa: BLE001 - the code of a task may raise anything
            return _Failure(len(self._envs), error)
        self._rows = [_Row(env, self._mode) for env in self._envs]
        first = self._envs[0]
        return first.observation_space, first.action_space, first.metadata, first.render_mode

    def do(self, method: str, arguments: Sequence[Any]) -> list[Any] | _Failure:
        """Return what each environment answers, or what the first cannot do."""
        answers: list[Any] = []
        try:
            for row, argument in zip(self._rows, arguments, strict=True):
                answers.append(getattr(row, method)(argument))
        except Exception as error:  # noqa: BLE001 - the code of a task may raise anything
            return _Failure(len(answers), error)
        return answers

    def close(self) -> None:
        for env in self._envs:
            env.close()


def _serve(pipe: Connection, make: MakeEnv, count: int, mode: str) -> None:
    """Run environments until the other end of the pipe is closed."""
    share = _Share(make, count, mode)
    try:
        answer: Any = share.begin()
        while True:
            pipe.send_bytes(_message_of(answer))
            answer = share.do(*pipe.recv())
    except (EOFError, BrokenPipeError, ConnectionResetError, KeyboardInterrupt):
        return


def _message_of(answer: Any) -> memoryview:
    """Return the bytes of an answer, or of the failure that it cannot be sent."""
    try:
        return ForkingPickler.dumps(answer)
    except Exception as error:  # noqa: BLE001 - what a class refuses to pickle with is its own
        return ForkingPickler.dumps(_Failure(0, error))


def vector_of(env_class: type[ArmEnv], num_envs: int = 1, **arguments: Any) -> ArmVectorEnv:
    """
    Return a vector of environments of a class; for ``gymnasium.make_vec``.

    :param arguments: those of the class, and ``autoreset_mode`` and ``workers``.
    """
    own = {name: arguments.pop(name) for name in ('autoreset_mode', 'workers')
           if name in arguments}
    return ArmVectorEnv(partial(env_class, **arguments), num_envs, **own)
