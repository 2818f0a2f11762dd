"""Several missions: their order, what is asked twice, what is cancelled before it begins, and history in pages."""

import pytest

from contracts.mission import Mission, MissionEvent, MissionState, MissionStatus, Outcome
from contracts.vision import ParsedTarget, ParsedTask
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing

RED = Thing("bottle", "red", 3.5, 2.5)
CUP = Thing("cup", "blue", 3.2, 3.4)
BOTH = ParsedTask(
    targets=(
        ParsedTarget(said="find the red bottle", yolo_class="bottle", description="red bottle", parser="rules"),
        ParsedTarget(said="the blue cup", yolo_class="cup", description="blue cup", parser="rules"),
    ),
)


async def ask(mesh: Mesh, command: str = "find the red bottle", key: str | None = None) -> Mission:
    headers = {"Idempotency-Key": key} if key is not None else {}
    answer = await mesh.client.post("/missions", json={"command": command}, headers=headers)
    assert answer.status_code == 201, answer.text
    return Mission.model_validate_json(answer.content)


async def listed(mesh: Mesh, **query: str | int) -> list[Mission]:
    answer = await mesh.client.get("/missions", params=query)
    assert answer.status_code == 200, answer.text
    return [Mission.model_validate(one) for one in answer.json()]


async def status(mesh: Mesh) -> MissionStatus:
    return MissionStatus.model_validate_json((await mesh.client.get("/state")).content)


async def test_a_second_mission_waits_and_begins_when_the_first_is_over(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await ask(mesh), await ask(mesh)
        assert (first.queue_position, second.queue_position) == (None, 0)
        assert [one.id for one in (await status(mesh)).queue] == [second.id]
        assert (await mesh.until_over(first.id)).outcome is Outcome.FOUND
        ended = await mesh.until_over(second.id)
        assert ended.outcome is Outcome.FOUND
        assert ended.started_s > (await mesh.mission(first.id)).started_s
        assert (await status(mesh)).queue == ()


async def test_one_command_with_two_things_makes_two_missions_in_the_order_said(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, CUP) as mesh:
        mesh.inference.parse = BOTH
        first = await ask(mesh, "find the red bottle, then the blue cup")
        assert (first.part, first.parts, first.target and first.target.label) == (1, 2, "bottle")
        assert (await mesh.until_over(first.id)).outcome is Outcome.FOUND
        second, _ = await listed(mesh)
        assert second.request_id == first.request_id
        ended = await mesh.until_over(second.id)
        assert (ended.part, ended.outcome) == (2, Outcome.FOUND)
        assert mesh.away_m(CUP) <= 0.5


async def test_what_is_not_known_of_several_things_is_left_out_and_told(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        unknown = ParsedTarget(said="my unicorn", yolo_class="none", parser="rules")
        mesh.inference.parse = BOTH.model_copy(update={"targets": (BOTH.targets[0], unknown)})
        mission = await ask(mesh, "find the red bottle and my unicorn")
        assert mission.parts == 1
        assert "my unicorn" in (await mesh.timeline(mission.id))[0].text


async def test_the_same_request_with_its_key_answers_with_the_same_mission(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, again = await ask(mesh, key="k1"), await ask(mesh, key="k1")
        assert again.id == first.id
        assert len(await listed(mesh)) == 1
        await mesh.until_over(first.id)
        assert (await ask(mesh, key="k1")).outcome is Outcome.FOUND
        assert (await ask(mesh, key="k2")).id != first.id


async def test_a_key_used_for_another_command_is_422_and_starts_nothing(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        await ask(mesh, key="k1")
        other = await mesh.client.post(
            "/missions", json={"command": "find the cup"}, headers={"Idempotency-Key": "k1"}
        )  # fmt: skip
        assert other.status_code == 422
        too_long = await mesh.client.post(
            "/missions", json={"command": "find the cup"}, headers={"Idempotency-Key": "k" * 101}
        )  # fmt: skip
        assert too_long.status_code == 422
        assert len(await listed(mesh)) == 1


async def test_a_queued_mission_can_be_cancelled_and_nothing_else(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await ask(mesh), await ask(mesh)
        assert (await mesh.client.post(f"/missions/{second.id}/pause")).status_code == 409
        canceled = Mission.model_validate_json((await mesh.client.post(f"/missions/{second.id}/cancel")).content)
        assert (canceled.outcome, canceled.queue_position) == (Outcome.CANCELED, None)
        assert canceled.report is not None
        assert (await mesh.client.post(f"/missions/{second.id}/cancel")).status_code == 409
        assert (await mesh.mission(first.id)).outcome is None


async def test_cancelling_the_running_one_lets_the_next_begin(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await ask(mesh), await ask(mesh)
        await mesh.client.post(f"/missions/{first.id}/cancel")
        assert (await mesh.until_over(second.id)).outcome is Outcome.FOUND


async def test_while_one_is_paused_the_next_waits(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await ask(mesh), await ask(mesh)
        await mesh.client.post(f"/missions/{first.id}/pause")
        await mesh.clock.advance(30.0)
        assert (await mesh.mission(second.id)).queue_position == 0


async def test_a_stop_ends_what_waits_too_and_nothing_begins_after_the_reset(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        await ask(mesh)
        second = await ask(mesh)
        await mesh.world.latch("a person")
        await mesh.clock.advance(0.5)
        ended = await mesh.mission(second.id)
        assert ended.outcome is Outcome.ABORTED
        assert "emergency stop" in ended.reason
        await mesh.world.reset()
        await mesh.clock.advance(10.0)
        assert (await status(mesh)).state is MissionState.IDLE


async def test_a_full_queue_is_429_and_takes_all_of_a_command_or_nothing(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, queue_max=2) as mesh:
        for _ in range(2):
            await ask(mesh)
        mesh.inference.parse = BOTH
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle, then the blue cup"})
        assert answer.status_code == 429
        assert len((await status(mesh)).queue) == 1


async def test_history_comes_in_pages_newest_first(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        made = [(await ask(mesh)).id for _ in range(5)]
        first_page = await listed(mesh, limit=2)
        second_page = await listed(mesh, limit=2, before=first_page[-1].id)
        last_page = await listed(mesh, limit=2, before=second_page[-1].id)
        assert [one.id for page in (first_page, second_page, last_page) for one in page] == made[::-1]
        assert (await mesh.client.get("/missions", params={"before": "nobody"})).status_code == 404


async def test_ids_of_events_rise_by_one_over_all_missions(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await ask(mesh), await ask(mesh)
        await mesh.until_over(second.id)
        events: list[MissionEvent] = [*await mesh.timeline(first.id), *await mesh.timeline(second.id)]
        assert sorted(event.id for event in events) == list(range(len(events)))


@pytest.mark.parametrize("verb", ["cancel", "pause", "resume"])
async def test_words_to_an_unknown_mission_change_nothing(open_mesh: OpenMesh, verb: str) -> None:
    async with open_mesh(RED) as mesh:
        mission = await ask(mesh)
        assert (await mesh.client.post(f"/missions/nobody/{verb}")).status_code == 404
        assert (await mesh.mission(mission.id)).paused is False
