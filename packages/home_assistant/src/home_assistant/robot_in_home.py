"""Tells Home Assistant of the robot, and does what is pressed and typed there (shell)."""

import asyncio
import contextlib
import json
import ssl
from collections.abc import Awaitable, Callable
from functools import partial
from http import HTTPStatus
from typing import Final, TypeVar

import aiomqtt
import structlog

from contracts.mission import Heard
from contracts.reading import Mood
from contracts.robot import EmergencyStopRequest
from home_assistant import states
from home_assistant.discovery import FIND_MAX, OFFLINE, ONLINE, PRESS, Entity, Topics, configs
from home_assistant.services import Coordinator, Robot
from home_assistant.settings import Settings
from mesh.clock import Clock
from mesh.errors import MeshError, UpstreamError
from vocabulary.orders import order_in

log = structlog.get_logger()

NEWEST: Final = 20
"""Missions among which the last find is looked for."""
WAITING_MAX: Final = 100
"""Messages that wait to be read; of more, the newest are lost."""
ASKED_AT_ONCE: Final = 4
OBEYED_S: Final = 1.0
"""So long the coordinator may take to say that a typed stop was obeyed."""
DOCK: Final = "go to the dock"
T = TypeVar("T")


class RobotInHome:
    """One robot at one broker. `run` never ends by itself: a broker that is away is tried again."""

    def __init__(self, settings: Settings, *, coordinator: Coordinator, robot: Robot, clock: Clock) -> None:
        self._settings = settings
        self._coordinator = coordinator
        self._robot = robot
        self._clock = clock
        self._topics = Topics.of(settings.identity)
        self._told: dict[str, str] = {}
        self._asking = 0
        self._stops: dict[Mood, asyncio.Task[str]] = {}
        """Under way, one of a mood. A stop goes on when the broker goes away, and to its end when the program ends."""

    async def run(self) -> None:
        try:
            while True:
                await self._serve_while_there()
                await self._clock.sleep(self._settings.reconnect_s)
        finally:
            if self._stops:
                await asyncio.wait(self._stops.values())

    async def _serve_while_there(self) -> None:
        try:
            async with self._client() as client:
                log.info("at the broker", host=self._settings.mqtt_host, port=self._settings.mqtt_port)
                await self._serve(client)
        except* aiomqtt.MqttError as errors:
            log.warning("no broker", reason=str(errors.exceptions[0]), again_s=self._settings.reconnect_s)
        task = asyncio.current_task()
        if task is not None and task.cancelling():  # and the broker went away while it ended
            raise asyncio.CancelledError

    def _client(self) -> aiomqtt.Client:
        settings = self._settings
        ca_file = str(settings.mqtt_ca_file) if settings.mqtt_ca_file is not None else None
        return aiomqtt.Client(
            settings.mqtt_host,
            settings.mqtt_port,
            username=settings.mqtt_username,
            password=settings.broker_password,
            identifier=f"atom-{settings.robot_id}",
            will=aiomqtt.Will(self._topics.availability, OFFLINE, qos=1, retain=True),
            tls_context=ssl.create_default_context(cafile=ca_file) if settings.mqtt_tls or ca_file else None,
            max_queued_incoming_messages=WAITING_MAX,
            keepalive=20,
        )

    async def _serve(self, client: aiomqtt.Client) -> None:
        topics = self._topics
        for entity in (Entity.STOP, Entity.DOCK, Entity.FIND):
            await client.subscribe(topics.command(entity), qos=1)
        await client.subscribe(topics.birth, qos=1)
        await self._announce(client)
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._tell(client), name="tell")
                if self._settings.camera:
                    group.create_task(self._show(client), name="show")
                async for message in client.messages:
                    self._heard(client, group, message)
        finally:
            with contextlib.suppress(aiomqtt.MqttError):  # where the broker is gone its will is done
                await client.publish(topics.availability, OFFLINE, qos=1, retain=True)

    async def _announce(self, client: aiomqtt.Client) -> None:
        """Everything anew: that it is here, what there is of it, and with the next look how it does."""
        for entity, config in configs(self._settings.identity).items():
            payload = "" if config is None else json.dumps(config)  # an empty one takes an old entity away
            await client.publish(self._topics.config(entity), payload, qos=1, retain=True)
        self._told.clear()
        await client.publish(self._topics.availability, ONLINE, qos=1, retain=True)

    # what is told

    async def _tell(self, client: aiomqtt.Client) -> None:
        while True:
            await self._tell_once(client)
            await self._clock.sleep(self._settings.state_period_s)

    async def _tell_once(self, client: aiomqtt.Client) -> None:
        status, robot, newest = await asyncio.gather(
            _if_there(self._coordinator.status),
            _if_there(self._robot.state),
            _if_there(partial(self._coordinator.newest, NEWEST)),
        )
        found, topics = states.last_found(newest or ()), self._topics
        await self._publish(client, topics.state(Entity.STATE), states.state_of(status, robot))
        await self._publish(client, topics.state(Entity.BATTERY), states.battery_of(robot))
        if newest is not None:  # else what was found last is as it was
            await self._publish(client, topics.state(Entity.LAST_FOUND), states.found_text(found))
            await self._publish(client, topics.attributes(Entity.LAST_FOUND), states.found_attributes(found))

    async def _publish(self, client: aiomqtt.Client, topic: str, text: str) -> None:
        """Retained, and only what is new."""
        if self._told.get(topic) != text:
            await client.publish(topic, text, qos=1, retain=True)
            self._told[topic] = text

    async def _show(self, client: aiomqtt.Client) -> None:
        """Pictures are not retained: the broker keeps none of the home."""
        while True:
            picture = await _if_there(self._robot.picture)
            if picture is not None:
                await client.publish(self._topics.state(Entity.CAMERA), picture)
            await self._clock.sleep(self._settings.camera_period_s)

    # what is asked for

    def _heard(self, client: aiomqtt.Client, group: asyncio.TaskGroup, message: aiomqtt.Message) -> None:
        """Begins what is asked for. What the broker kept from before nobody asks for now: it moves nothing."""
        topic, payload = message.topic.value, message.payload
        if topic == self._topics.birth:
            if payload == ONLINE.encode():
                group.create_task(self._announce(client), name="announce")
            return
        if message.retain:
            log.warning("a command that the broker kept is not obeyed", topic=topic)
            return
        text = payload.decode("utf-8", "replace")
        if topic == self._topics.command(Entity.STOP):
            if text == PRESS:
                self._obey(client, group, Mood.EMERGENCY, "")
            return
        command = DOCK if topic == self._topics.command(Entity.DOCK) else text.strip()
        if topic == self._topics.command(Entity.DOCK) and text != PRESS:
            return
        order = order_in(command) if len(command) <= FIND_MAX else None
        if order is not None and order.mood is not Mood.RESUME:
            self._obey(client, group, order.mood, command)
            return
        if self._asking >= ASKED_AT_ONCE:
            log.warning("too much is asked at once", command=command[:FIND_MAX])
            return
        self._asking += 1
        group.create_task(self._ask(client, command), name="ask")

    def _obey(self, client: aiomqtt.Client, group: asyncio.TaskGroup, mood: Mood, typed: str) -> None:
        """Begins a stop, beside whatever else was asked for; only what is told of it needs the broker. `typed` is
        empty where the button was pressed."""
        if mood in self._stops:
            log.info("such a stop is under way", mood=mood.value)
            return
        stop = asyncio.create_task(_in_words(self._obeyed(mood, typed)), name="stop")
        self._stops[mood] = stop
        stop.add_done_callback(lambda _: self._stops.pop(mood))
        group.create_task(self._tell_of_stop(client, stop, typed), name="tell of the stop")

    async def _obeyed(self, mood: Mood, typed: str) -> str:
        """What the coordinator does not confirm soon becomes the emergency stop."""
        if mood is not Mood.EMERGENCY and typed.isprintable():
            try:
                async with asyncio.timeout(OBEYED_S):
                    heard = await self._coordinator.start(typed)
                if not isinstance(heard, Heard) or heard.still or mood is Mood.PAUSE:
                    return states.answer_to(heard)
                log.warning("after a typed stop it may still move: the emergency stop instead")
            except (MeshError, TimeoutError) as error:
                log.warning("a typed stop was not confirmed: the emergency stop instead", error=str(error))
        reason = f"typed in Home Assistant: {typed[:100]}" if typed else "STOP pressed in Home Assistant"
        await self._robot.emergency_stop(EmergencyStopRequest(reason=reason, by="home_assistant"))
        return "stopped"

    async def _tell_of_stop(self, client: aiomqtt.Client, stop: "asyncio.Task[str]", typed: str) -> None:
        await self._tell_answer(client, await asyncio.shield(stop))
        if typed:
            await client.publish(self._topics.state(Entity.FIND), typed, qos=1, retain=True)

    async def _ask(self, client: aiomqtt.Client, command: str) -> None:
        try:
            if command != DOCK:
                await client.publish(self._topics.state(Entity.FIND), command[:FIND_MAX], qos=1, retain=True)
            await self._tell_answer(client, await _in_words(self._started(command)))
        finally:
            self._asking -= 1

    async def _started(self, command: str) -> str:
        if not command or len(command) > FIND_MAX or not command.isprintable():
            return "say what to find, for example: red bottle"
        return states.answer_to(await self._coordinator.start(command))

    async def _tell_answer(self, client: aiomqtt.Client, text: str) -> None:
        """What came of it, as the sensor `answer`; it is told again where it is the same."""
        await client.publish(self._topics.state(Entity.ANSWER), text[:FIND_MAX], qos=1, retain=True)


async def _in_words(doing: Awaitable[str]) -> str:
    """What came of it, or why nothing did."""
    try:
        return await doing
    except UpstreamError as error:
        refused = error.upstream_status < HTTPStatus.INTERNAL_SERVER_ERROR
        return error.said if refused else f"{error.service} failed"
    except MeshError as error:
        return str(error)


async def _if_there(ask: Callable[[], Awaitable[T]]) -> T | None:
    """None where the service is away or refuses."""
    try:
        return await ask()
    except MeshError as error:
        log.info("could not be asked", error=str(error))
        return None
