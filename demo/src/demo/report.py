"""What a demo leaves behind: mission.json, the last annotated frame, a map with the path and the remembered views."""

import json
import math
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from PIL import Image, ImageDraw
from pydantic import TypeAdapter

from contracts.geometry import Pose2D
from contracts.memory import View
from contracts.mission import Outcome
from contracts.robot import Map
from demo.mission_watch import Watched
from demo.stack import Ports
from geometry.grids import decode

PX_PER_CELL = 4
VIEWS = TypeAdapter(list[View])


def write_report(folder: Path, ports: Ports, watched: Watched, *, command: str, seed: int) -> dict[str, Any]:
    """Writes the files under `folder` and returns what mission.json says."""
    folder.mkdir(parents=True, exist_ok=True)
    with httpx.Client(trust_env=False, timeout=10.0) as client:
        told = _told(client, ports, watched, command=command, seed=seed)
        frame = client.get(f"{ports.url('inference')}/annotated")
        if frame.is_success:
            (folder / "frame.jpg").write_bytes(frame.content)
        _draw_map(client, ports, watched).save(folder / "map.png")
    (folder / "mission.json").write_text(json.dumps(told, indent=2) + "\n")
    (folder / "events.json").write_text(json.dumps([e.model_dump() for e in watched.events], indent=2) + "\n")
    return told


def _told(client: httpx.Client, ports: Ports, watched: Watched, *, command: str, seed: int) -> dict[str, Any]:
    mission = watched.mission
    truth: dict[str, Any] = client.get(f"{ports.url('truth')}/truth").json()
    score: dict[str, Any] = {}
    if mission.target is not None:
        colour = mission.target.colour
        query = {"kind": mission.target.label} | ({"colour": colour.value} if colour else {})
        answer = client.get(f"{ports.url('truth')}/score", params=query)
        score = answer.json() if answer.is_success else {}
    seconds = (mission.ended_s or mission.started_s) - mission.started_s
    return {
        "command": command,
        "seed": seed,
        "outcome": mission.outcome,
        "reason": mission.reason,
        "seconds": round(seconds, 1),
        "metres": round(mission.metres_driven_m, 2),
        "votes": [vote.model_dump(mode="json") for vote in mission.votes],
        "measured_distance_m": mission.measured_distance_m,
        "true_distance_m": score.get("true_distance_m"),
        "nearest_possible_m": score.get("nearest_possible_m"),
        "correct": mission.outcome is Outcome.FOUND and bool(score.get("correct")),
        "real_time_factor": truth.get("real_time", {}).get("factor"),
        "collisions": truth.get("collisions"),
        "parser": mission.parser,
    }


def _draw_map(client: httpx.Client, ports: Ports, watched: Watched) -> Image.Image:
    grid = decode(Map.model_validate_json(client.get(f"{ports.url('robot_bridge')}/map").content))
    height, width = grid.cells.shape
    shade = np.where(grid.occupied, 40, np.where(grid.free, 250, 190)).astype(np.uint8)
    size = (width * PX_PER_CELL, height * PX_PER_CELL)
    picture = Image.fromarray(shade[::-1]).resize(size, Image.Resampling.NEAREST).convert("RGB")
    draw = ImageDraw.Draw(picture)

    def pixel(pose: Pose2D) -> tuple[float, float]:
        column, row = (float(each) for each in grid.columns_and_rows(np.array(pose.x), np.array(pose.y)))
        return column * PX_PER_CELL, (height - row) * PX_PER_CELL

    for view in _views(client, ports, watched):
        x, y = pixel(view.pose)
        turn = view.pose.yaw - grid.origin.yaw
        draw.line((x, y, x + 10 * math.cos(turn), y - 10 * math.sin(turn)), fill=(230, 150, 30), width=2)
        draw.ellipse((x - 3, y - 3, x + 3, y + 3), fill=(230, 150, 30))
    if len(watched.track) > 1:
        draw.line([pixel(pose) for pose in watched.track], fill=(40, 90, 220), width=3)
    if watched.track:
        x, y = pixel(watched.track[-1])
        draw.ellipse((x - 7, y - 7, x + 7, y + 7), outline=(40, 90, 220), width=3)
    if watched.mission.target_pose is not None:
        x, y = pixel(watched.mission.target_pose)
        draw.ellipse((x - 5, y - 5, x + 5, y + 5), fill=(220, 30, 30))
    return picture


def _views(client: httpx.Client, ports: Ports, watched: Watched) -> list[View]:
    if watched.mission.target is None:
        return []
    answer = client.get(f"{ports.url('memory')}/views", params={"label": watched.mission.target.label, "limit": 200})
    return VIEWS.validate_json(answer.content) if answer.is_success else []
