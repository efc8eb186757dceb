# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page: its sessions, what they share, and the parts that answer them."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping
from concurrent.futures import Future
import itertools
import json
import sys
import traceback
from typing import Any

from moveit_msgs.srv import GetPlanningScene
from pydantic import BaseModel, ConfigDict, ValidationError
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.json_text import to_json
from armsim_ros.nodes.web.server import SESSION, WebServer

#: A panel gets no more than so many messages a second.
_PANEL_RATE = 30.0


class Session:
    """
    A browser's tab; it stays the same when the tab is loaded again.

    :param key: the tab's own name for itself.
    :param number: shown to other sessions.
    """

    def __init__(self, key: str, number: int) -> None:
        self.key, self.number = key, number
        self.scene: Any = None
        """viser's client, None while the tab has no scene."""
        self.left_at = 0.0
        """When the last panel closed [s]; only of use where there is none."""
        self.sections: dict[str, Any] = {}
        self._panels: set[_Panel] = set()

    @property
    def present(self) -> bool:
        """Whether a panel is open."""
        return bool(self._panels)

    def show(self, name: str, value: Any) -> None:
        """Show this session a section; what has not changed is not sent again."""
        if name not in self.sections or self.sections[name] != value:
            self.sections[name] = value
            self.send(name, value)

    def send(self, name: str, value: Any) -> None:
        """Put a section on its way to the session's panels."""
        for panel in self._panels:
            panel.put(name, value)

    def note(self, text: str, level: str = 'error') -> None:
        """Show a line below the status, once."""
        self.sections.pop('note', None)
        self.show('note', {'text': text, 'level': level})

    async def talk(self, connection: ServerConnection, shared: Mapping[str, Any],
                   receive: Any) -> None:
        """
        Serve a panel until it closes.

        :param receive: gets each message that is a JSON object.
        """
        panel = _Panel(connection)
        for name, value in {**shared, **self.sections}.items():
            panel.put(name, value)
        self._panels.add(panel)
        sender = asyncio.create_task(panel.send_all())
        try:
            async for text in connection:
                message = json.loads(text) if isinstance(text, str) else None
                if not isinstance(message, dict):
                    await connection.close(1003, 'not understood')
                    return
                receive(message)
        except (ValueError, RecursionError):
            await connection.close(1003, 'not understood')
        finally:
            self._panels.discard(panel)
            sender.cancel()
            self.left_at = asyncio.get_running_loop().time()


class _Panel:
    """The channel to a panel: the newest value of each section, and no queue behind it."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection
        self._waiting: dict[str, Any] = {}
        self._news = asyncio.Event()

    def put(self, name: str, value: Any) -> None:
        self._waiting[name] = value
        self._news.set()

    async def send_all(self) -> None:
        try:
            while True:
                await self._news.wait()
                self._news.clear()
                batch, self._waiting = self._waiting, {}
                await self._connection.send(to_json(batch))
                await asyncio.sleep(1.0 / _PANEL_RATE)
        except ConnectionClosed:
            return


#: How long a tab that was closed keeps its goal and its plan [s].
_MEMORY = 600.0
_MOST_SESSIONS = 200
#: How long an answer of a service may take [s].
PATIENCE = 5.0


class PanelCommand(BaseModel):
    """A panel's command, validated; a class per kind of command."""

    model_config = ConfigDict(extra='forbid', strict=False, allow_inf_nan=False,
                              str_max_length=40_000_000)


Handler = Callable[[Session, Any], Awaitable[None]]


class Part:
    """A function of the page; the page notifies it of events."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def handlers(self) -> dict[str, tuple[type[PanelCommand], Handler]]:
        """Return what it answers: a question's name -> its form and the answer."""
        return {}

    def on_robot(self, robot: RobotModel) -> None:
        """Take a robot that has appeared or changed."""

    def on_session(self, session: Session) -> None:
        """Handle a session's first panel; its scene may follow later, or never."""

    def on_scene(self, session: Session) -> None:
        """Draw what is specific to a session in its new scene."""

    def on_program(self, name: str, there: bool) -> None:
        """Take note that a program has come or gone."""

    async def run(self) -> None:
        """Do what goes on all the time."""


class Page:
    """Works in the event loop of the page's server; ROS lives in the link's thread."""

    def __init__(self, link: RosClient) -> None:
        self.link = link
        self.shared: dict[str, Any] = {}
        self.sessions: dict[str, Session] = {}
        self.robot: RobotModel | None = None
        self.parts: list[Part] = []
        self.server: WebServer
        self._handlers: dict[str, tuple[type[PanelCommand], Handler]] = {}
        self._numbers = itertools.count(1)
        self._tasks: set[asyncio.Task[Any]] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self.arrival = asyncio.Event()

    def open(self, host: str, port: int, token: str, parts: Callable[[Page], Iterable[Part]]
             ) -> None:
        """
        Open the server and let the parts work.

        :raises ServingError: the page cannot be served there.
        """
        self.server = WebServer(host, port, token, self._on_panel)
        server = self.server.viser
        self._loop = server.get_event_loop()

        async def begin() -> None:
            self.arrival = asyncio.Event()
            self.parts = list(parts(self))
            for part in self.parts:
                self._handlers.update(part.handlers())
                self.start(part.run())
            self.start(self._forget_sessions())

        asyncio.run_coroutine_threadsafe(begin(), self._loop).result(10.0)

        @server.on_client_connect
        async def _(client: Any) -> None:
            self._on_scene(SESSION.get(), client)

        @server.on_client_disconnect
        async def _(client: Any) -> None:
            for session in self.sessions.values():
                if session.scene is client:
                    session.scene = None

    def halt(self) -> None:
        """End all that goes on; the link may be closed then."""
        async def cancel() -> None:
            for task in self._tasks:
                task.cancel()

        assert self._loop is not None
        asyncio.run_coroutine_threadsafe(cancel(), self._loop).result(PATIENCE)

    def close(self) -> None:
        """Accept no more connections."""
        self.halt()
        self.server.close()

    @property
    def scene(self) -> Any:
        """The scene that all sessions see."""
        return self.server.viser.scene

    @property
    def watched(self) -> bool:
        """Whether any panel is open."""
        return any(session.present for session in self.sessions.values())

    def publish(self, name: str, value: Any) -> None:
        """Show all sessions a section; what has not changed is not sent again."""
        if name not in self.shared or self.shared[name] != value:
            self.shared[name] = value
            for session in self.sessions.values():
                session.send(name, value)

    def start(self, work: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        """Do something beside everything else; what it raises is printed, not lost."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._finished)
        return task

    def soon(self, work: Callable[[], Any]) -> None:
        """Do something in the event loop; from any thread."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(work)

    async def answer(self, future: Future[Any], patience: float = PATIENCE) -> Any:
        """
        Wait for what the link's thread brings.

        :param patience: [s].
        :raises ArmsimError: it does not come in time.
        """
        try:
            return await asyncio.wait_for(asyncio.wrap_future(future), patience)
        except (asyncio.TimeoutError, TimeoutError):
            raise ArmsimError(f'no answer within {patience:.0f} s') from None

    async def call(self, kind: type[Any], name: str, request: Any = None,
                   patience: float = PATIENCE) -> Any:
        """
        Call a service and return its response.

        :raises ArmsimError: the service is missing or does not answer in time.
        """
        try:
            return await self.answer(self.link.call(kind, name, request), patience)
        except ArmsimError as error:
            text = str(error)
            raise ArmsimError(text if name in text else f'{name}: {text}') from None

    async def planning_scene(self, components: int, patience: float = PATIENCE) -> Any:
        """
        Return the parts of move_group's scene that a sum of PlanningSceneComponents names.

        :raises ArmsimError: move_group does not answer.
        """
        request = GetPlanningScene.Request()
        request.components.components = components
        answer = await self.call(GetPlanningScene, '/get_planning_scene', request, patience)
        return answer.scene

    def take_robot(self, robot: RobotModel) -> None:
        """Let every part know the robot."""
        self.robot = robot
        for part in self.parts:
            part.on_robot(robot)

    def take_program(self, name: str, there: bool) -> None:
        """Let every part know that a program came or went."""
        for part in self.parts:
            part.on_program(name, there)

    async def _on_panel(self, key: str, connection: ServerConnection) -> None:
        session = self._session(key)
        self.arrival.set()
        for part in self.parts:
            part.on_session(session)
        await session.talk(connection, self.shared, lambda values: self._receive(session, values))

    def _on_scene(self, key: str, client: Any) -> None:
        if not key:
            return
        session = self._session(key)
        session.scene = client
        for part in self.parts:
            part.on_scene(session)

    def _session(self, key: str) -> Session:
        if key not in self.sessions:
            self.sessions[key] = session = Session(key, next(self._numbers))
            session.left_at = asyncio.get_running_loop().time()
            session.show('me', session.number)
        return self.sessions[key]

    def _receive(self, session: Session, command: dict[str, Any]) -> None:
        name = command.pop('do', None)
        if not isinstance(name, str) or name not in self._handlers:
            session.note(f'the page does not know the command {str(name)[:40]!r}; load it again')
            return
        form, handler = self._handlers[name]
        try:
            checked = form.model_validate(command)
        except ValidationError as error:
            first = error.errors()[0]
            where = '.'.join(map(str, first['loc']))
            session.note(f"{name}: {where or 'the question'}: {first['msg']}")
            return
        self.start(self._handle(session, name, handler, checked))

    async def _handle(self, session: Session, name: str, handler: Handler,
                      command: PanelCommand) -> None:
        try:
            await handler(session, command)
        except ArmsimError as error:
            session.note(str(error))
        except Exception as error:
            session.note(f'{name} failed inside the page: {error}')
            raise

    def _finished(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            print('the page has a bug; please report this:', file=sys.stderr)
            traceback.print_exception(task.exception())

    async def _forget_sessions(self) -> None:
        """Forget tabs that were closed long ago, and the oldest where there are too many."""
        while True:
            await asyncio.sleep(10.0)
            now = asyncio.get_running_loop().time()
            gone = sorted((session for session in self.sessions.values()
                           if not session.present and session.scene is None),
                          key=lambda session: session.left_at)
            spare = len(self.sessions) - _MOST_SESSIONS
            for index, session in enumerate(gone):
                if index < spare or now - session.left_at > _MEMORY:
                    del self.sessions[session.key]
