"""The failures on the map: where the robot went, where the thing stands, and what the mission said."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.results import pyplot
from bench.search.episode import Episode
from bench.search.report import NEAR, is_right
from sim.home import Home
from sim.world import World

STATES_TOLD = 14


def gallery(records: Sequence[dict[str, Any]], folder: Path, *, most: int = 40) -> Path:
    """A page with a map and the last lines of the timeline for each mission that did not end as it should."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# What did not end as it should", ""]
    missed = [record for record in records if not all(is_right(row) for row in record["missions"])]
    for record in missed[:most]:
        episode = Episode.model_validate(record["episode"])
        picture = folder / f"{episode.name.replace('/', '-')}.png"
        draw(record, episode, picture)
        lines += [f"## {episode.name}", "", f"![{episode.name}]({picture.name})", ""]
        for row in record["missions"]:
            if not is_right(row):
                took = f"{row.get('seconds', 0.0):g} s and {row.get('metres', 0.0):g} m"
                lines.append(f"'{row['command']}': **{row['outcome']}** after {took} (floor {row['floor_s'][NEAR]} s):")
                lines += [row["reason"], ""]
                told = row.get("timeline", [])[-STATES_TOLD:]
                began_s = row["mission"]["started_s"] if told else 0.0
                lines += [f"- {line['stamp_s'] - began_s:.1f} s {line['state']}: {line['text']}" for line in told]
                lines.append("")
    page = folder / "README.md"
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return page


def draw(record: dict[str, Any], episode: Episode, to: Path) -> None:
    """The map as it was at the start, the way driven, the ends of the missions, and the things asked for."""
    home = Home.generate(episode.home_seed)
    for carried in episode.since_tour:
        home = carried.done_to(home)
    with World(home) as world:
        grid, things = world.grid, world.truth.things
    plt = pyplot()
    height, width = grid.data.shape
    extent = (
        grid.origin_x_m, grid.origin_x_m + width * grid.resolution_m,
        grid.origin_y_m, grid.origin_y_m + height * grid.resolution_m,
    )  # fmt: skip
    figure, axes = plt.subplots(figsize=(7, 7 * height / width))
    shade = np.where(grid.data == 0, 1.0, np.where(grid.data > 0, 0.2, 0.8))
    axes.imshow(shade, cmap="gray", origin="lower", extent=extent, vmin=0.0, vmax=1.0)
    if record.get("track"):
        _, x, y, _ = np.array(record["track"]).T
        axes.plot(x, y, linewidth=1.2)
    axes.plot(episode.start.x, episode.start.y, "o", color="tab:blue")
    asked = [one for command in episode.commands for one in command.asked]
    for thing in things:
        if any(thing.kind == one.kind and one.colour in {None, thing.colour} for one in asked):
            axes.plot(thing.x_m, thing.y_m, "*", color="tab:green", markersize=12)
        elif any(thing.kind == one.kind for one in asked):
            axes.plot(thing.x_m, thing.y_m, "x", color="tab:orange")
    for row in record["missions"]:
        if row.get("pose") is not None:
            pose = row["pose"]
            axes.arrow(pose["x"], pose["y"], 0.25 * np.cos(pose["yaw"]), 0.25 * np.sin(pose["yaw"]),
                       width=0.04, color="tab:red")  # fmt: skip
    axes.set_title("; ".join(f"{row['command']}: {row['outcome']}" for row in record["missions"])[:90], fontsize=8)
    axes.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(to, dpi=90)
    plt.close(figure)
