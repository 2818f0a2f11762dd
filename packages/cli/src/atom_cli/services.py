"""The services over HTTP, as a terminal needs them.

ServiceError
|- AwayError       not reachable, or not answering in time
`- RefusedError    it said no; the message is its own
"""

import contextlib
import uuid
from collections.abc import Generator, Sequence
from ipaddress import IPv6Address
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Final, NoReturn, Self, TypeVar

import httpx
from pydantic import TypeAdapter, ValidationError

from contracts.actions import Action, ActionReply, StopAction
from contracts.asking import Answer, Question
from contracts.backup import SCHEMA_HEADER, BackupService, RestoreHold, RestoreReply
from contracts.intent import Understand, Understood
from contracts.memory import LabelCount, RememberedObject
from contracts.mission import Heard, Mission, MissionEvent, MissionStatus, StartMission
from contracts.problem import Problem, Readiness
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, RobotState
from contracts.speech import Transcript

T = TypeVar("T")

PORTS: Final = {"coordinator": 1, "inference": 2, "memory": 3, "robot_bridge": 4, "speech": 5}
DATABASES: Final = {
    BackupService.COORDINATOR: ("coordinator", ""),
    BackupService.EXPLORATION: ("coordinator", "/exploration"),
    BackupService.MEMORY: ("memory", ""),
}
"""Who keeps each, and below which path it is copied."""
STOP_TRIES: Final = 3
STARTING_S: Final = 60.0
"""Reading a command may ask a language model."""
COPYING: Final = httpx.Timeout(300.0, connect=2.0)
"""A database is read, or judged whole, before an answer begins."""
HEARING_S: Final = 20.0


STARTED: Final[TypeAdapter[Mission | Heard]] = TypeAdapter(Mission | Heard)
OBEYED_S: Final = 2.5
"""So long the coordinator may take to say that an order was obeyed."""


class ServiceError(Exception):
    """Says which service, and what went wrong."""


class AwayError(ServiceError):
    pass


class RefusedError(ServiceError):
    pass


def host_of(said: str) -> str:
    """The name or address in what a person gave for it: 'robot.local', '::1', '[::1]', 'http://10.0.0.7/'.

    Raises `ValueError`, which says what is wrong, for what is more than that.
    """
    text = said.strip()
    with contextlib.suppress(ValueError):
        return str(IPv6Address(text))
    try:
        url = httpx.URL(text if "://" in text else f"http://{text}")
    except httpx.InvalidURL as error:
        raise ValueError(f"{said!r} is no name or address of a host: {error}") from error
    if url.scheme != "http":
        raise ValueError(f"the services speak http, not {url.scheme}")
    if url.port is not None:
        raise ValueError(f"say {url.host} alone: the ports of the services are --port-base + 1 to + 5")
    if not url.host or "%20" in url.host or url.userinfo or url.path != "/" or url.query or url.fragment:
        raise ValueError(f"{said!r} is no name or address of a host")
    return url.host


class Services:
    """`with Services(host, port_base) as services`; `host` as `host_of` gives it. Every call raises `ServiceError`."""

    def __init__(
        self, host: str, port_base: int, *, key: str = "", transport: httpx.BaseTransport | None = None
    ) -> None:
        """`key` '' = none: services without keys ask for none. A stop is sent without it: no key can be in its way."""
        self._key = {"Authorization": f"Bearer {key}"} if key else {}
        self._host = host
        self._port_base = port_base
        self._http = httpx.Client(
            trust_env=False,
            timeout=httpx.Timeout(5.0, connect=2.0),
            transport=transport,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._http.close()

    def start(self, command: str, *, timeout_s: float = STARTING_S) -> Mission | Heard:
        """A mission, or the answer to an order ('stop') or to a wish taken back."""
        body = StartMission(command=command).model_dump_json()
        headers = {"Idempotency-Key": uuid.uuid4().hex, "content-type": "application/json"}
        answer = self._call("coordinator", "POST", "/missions", content=body, headers=headers, timeout=timeout_s)
        return self._parsed("coordinator", answer, STARTED)

    def ask(self, question: str) -> Answer:
        body = Question(question=question).model_dump_json()
        headers = {"content-type": "application/json"}
        answer = self._call("coordinator", "POST", "/ask", content=body, headers=headers, timeout=STARTING_S)
        return self._parsed("coordinator", answer, TypeAdapter(Answer))

    def transcribe(self, wav: bytes, hot_words: Sequence[str]) -> Transcript:
        headers = {"content-type": "audio/wav"}
        answer = self._call(
            "speech",
            "POST",
            "/transcribe",
            content=wav,
            params={"hot_words": list(hot_words)},
            headers=headers,
            timeout=HEARING_S,
        )
        return self._parsed("speech", answer, TypeAdapter(Transcript))

    def understand(self, readings: Sequence[str]) -> Understood:
        """The likeliest reading first."""
        body = Understand(readings=tuple(readings)).model_dump_json()
        headers = {"content-type": "application/json"}
        answer = self._call("coordinator", "POST", "/understand", content=body, headers=headers, timeout=STARTING_S)
        return self._parsed("coordinator", answer, TypeAdapter(Understood))

    def do(self, action: Action, *, timeout_s: float = STARTING_S) -> ActionReply:
        """One declared action; what moves is a mission that has begun, or waits. To stop needs no key."""
        if isinstance(action, StopAction):
            answer = self._call("coordinator", "POST", "/actions/stop", key={}, timeout=timeout_s)
        else:
            headers = {"content-type": "application/json"}
            body = action.model_dump_json(exclude_none=True)
            answer = self._call("coordinator", "POST", "/actions", content=body, headers=headers, timeout=timeout_s)
        return self._parsed("coordinator", answer, TypeAdapter(ActionReply))

    def missions(self, limit: int) -> list[Mission]:
        """The newest first."""
        return self._get("coordinator", "/missions", list[Mission], limit=limit)

    def mission(self, mission_id: str) -> Mission:
        return self._get("coordinator", f"/missions/{mission_id}", Mission)

    def events(self, mission_id: str, *, after: int) -> list[MissionEvent]:
        return self._get("coordinator", f"/missions/{mission_id}/events", list[MissionEvent], after=after)

    def status(self) -> MissionStatus:
        return self._get("coordinator", "/state", MissionStatus)

    def robot(self) -> RobotState:
        return self._get("robot_bridge", "/state", RobotState)

    def labels(self) -> list[LabelCount]:
        return self._get("memory", "/labels", list[LabelCount])

    def objects(self, label: str | None) -> list[RememberedObject]:
        return self._get("memory", "/objects", list[RememberedObject], **({"label": label} if label else {}))

    def ready(self, service: str) -> str:
        """'' when it is; else what it lacks."""
        try:
            answer = self._http.get(self._url(service, "/ready"))
        except httpx.HTTPError:
            return "not reachable"
        if answer.is_success:
            return ""
        try:
            lacking = [one.name for one in Readiness.model_validate_json(answer.content).dependencies if not one.ok]
        except ValidationError:
            return f"HTTP {answer.status_code}"
        return f"lacks {', '.join(lacking)}"

    def back_up(self, service: BackupService, into: BinaryIO) -> str:
        """Writes the service's database into the file; returns the revision of its schema."""
        keeper, path = DATABASES[service]
        url = self._url(keeper, f"{path}/backup")
        with (
            self._naming(keeper),
            self._http.stream("GET", url, headers=self._key, timeout=COPYING) as answer,
        ):
            if not answer.is_success:
                answer.read()
                self._refuse(keeper, answer)
            for part in answer.iter_bytes():
                into.write(part)
            if SCHEMA_HEADER not in answer.headers:
                raise RefusedError(f"{keeper} answered with something else than its contract")
            return answer.headers[SCHEMA_HEADER]

    def hold_missions(self, seconds: float) -> None:
        """From now on none begins for so long; 0: they may again. One that is being read is waited for."""
        body = RestoreHold(seconds=seconds).model_dump_json()
        headers = {"content-type": "application/json"}
        self._call("coordinator", "POST", "/restore/hold", content=body, headers=headers, timeout=STARTING_S)

    def restore(self, service: BackupService, database: Path, *, dry_run: bool) -> RestoreReply:
        """Has it take the database in the file; `dry_run`: only judge it."""
        keeper, path = DATABASES[service]
        with database.open("rb") as file:
            answer = self._call(
                keeper,
                "POST",
                f"{path}/restore",
                params={"dry_run": dry_run},
                content=file,
                headers={"content-length": str(database.stat().st_size), "content-type": "application/octet-stream"},
                timeout=COPYING,
            )
        return self._parsed(keeper, answer, TypeAdapter(RestoreReply))

    def stop(self) -> EmergencyStopReply:
        """Straight to robot_bridge; a try that got no answer is followed by another, which does no harm."""
        for _ in range(STOP_TRIES - 1):
            try:
                return self._stop("/emergency-stop", "atom stop", key={})
            except AwayError:
                continue
        return self._stop("/emergency-stop", "atom stop", key={})

    def resume(self) -> EmergencyStopReply:
        return self._stop("/emergency-stop/reset", "atom resume", key=self._key)

    def _stop(self, path: str, reason: str, *, key: dict[str, str]) -> EmergencyStopReply:
        body = EmergencyStopRequest(reason=reason, by="terminal").model_dump_json()
        headers = {"content-type": "application/json"}
        answer = self._call("robot_bridge", "POST", path, key=key, content=body, headers=headers)
        return self._parsed("robot_bridge", answer, TypeAdapter(EmergencyStopReply))

    def _get(self, service: str, path: str, reply: type[T], **query: Any) -> T:
        return self._parsed(service, self._call(service, "GET", path, params=query), TypeAdapter(reply))

    def _call(
        self, service: str, method: str, path: str, *, key: dict[str, str] | None = None, **more: Any
    ) -> httpx.Response:
        headers = {**(self._key if key is None else key), **more.pop("headers", {})}
        with self._naming(service):
            answer = self._http.request(method, self._url(service, path), headers=headers, **more)
        if not answer.is_success:
            self._refuse(service, answer)
        return answer

    @contextlib.contextmanager
    def _naming(self, service: str) -> Generator[None]:
        try:
            yield
        except httpx.TimeoutException as error:
            raise AwayError(f"{service} does not answer in time") from error
        except httpx.TransportError as error:
            raise AwayError(f"{service} is not reachable at {self._url(service, '/')}") from error

    def _refuse(self, service: str, answer: httpx.Response) -> NoReturn:
        try:
            problem = Problem.model_validate_json(answer.content)
        except ValidationError:
            raise RefusedError(f"{service}: HTTP {answer.status_code}") from None
        remedy = "; a key goes into ATOM_KEY or ATOM_KEY_FILE (`atom keys make NAME`)" * (answer.status_code == 401)
        raise RefusedError(f"{service}: {problem.detail or problem.title}{remedy}")

    def _parsed(self, service: str, answer: httpx.Response, reply: TypeAdapter[T]) -> T:
        try:
            return reply.validate_json(answer.content)
        except ValidationError as error:
            raise RefusedError(f"{service} answered with something else than its contract") from error

    def _url(self, service: str, path: str) -> httpx.URL:
        return httpx.URL(scheme="http", host=self._host, port=self._port_base + PORTS[service], path=path)
