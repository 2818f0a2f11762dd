"""Rows of the tables to things and views, and back."""

import json
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement

from memory.adapters.tables import things, views
from memory.objects import MapObject
from memory.ports import StoredView
from memory.views import AggregatedView

Values = dict[str, Any]


THING: tuple[ColumnElement[Any], ...] = tuple(things.c[one.name] for one in fields(MapObject))
"""What a thing is read as: rows are taken by position, for recall reads a hundred at a time."""
COLOURS_AT = [one.name for one in fields(MapObject)].index("colours")


def thing_of(row: Sequence[Any]) -> MapObject:
    """Of a row of `THING`."""
    values = list(row)
    values[COLOURS_AT] = json.loads(values[COLOURS_AT])
    values[-1] = tuple(np.frombuffer(values[-1], "<f2").astype(float).tolist()) if values[-1] else ()
    return MapObject(*values)


def row_of(thing: MapObject) -> Values:
    """Without its id and its links, which are the store's to give."""
    return {
        "map_number": thing.map_number,
        "label": thing.label,
        "x": thing.x,
        "y": thing.y,
        "z": thing.z,
        "variance_m2": thing.variance_m2,
        "belief": thing.belief,
        "believed_s": thing.believed_s,
        "confidence": thing.confidence,
        "first_seen_s": thing.first_seen_s,
        "last_seen_s": thing.last_seen_s,
        "times_seen": thing.times_seen,
        "colours": json.dumps({word: round(votes, 3) for word, votes in thing.colours.items()}),
        "times_missed": thing.times_missed,
        "last_missed_s": thing.last_missed_s,
        "miss_x": thing.miss_x,
        "miss_y": thing.miss_y,
        "miss_loss": thing.miss_loss,
        "embedding_model": thing.embedding_model,
        "embedding": np.asarray(thing.embedding, "<f2").tobytes(),
    }


VIEW: tuple[ColumnElement[Any], ...] = (
    views.c.id,
    views.c.label,
    views.c.colour,
    views.c.x,
    views.c.y,
    views.c.yaw,
    views.c.confidence,
    views.c.last_seen_s,
    views.c.sightings,
    views.c.belief,
    views.c.believed_s,
    views.c.map_number,
    views.c.thing_id,
)
"""What a view is read as, in the order of `StoredView`: recall reads hundreds."""


def view_of(row: Sequence[Any], colour: str | None = None) -> StoredView:
    """Of a row of `VIEW`. `colour`, where given, is the thing's."""
    return StoredView(*row) if colour is None else StoredView(row[0], row[1], colour, *row[3:])


def row_of_sighting(sighting: AggregatedView, thing_id: int | None) -> Values:
    place, pose = sighting.place, sighting.pose
    return {
        "map_number": place.map_number,
        "label": place.label,
        "colour": place.colour,
        "cell_x": place.cell_x,
        "cell_y": place.cell_y,
        "sector": place.sector,
        "thing_id": thing_id,
        "x": pose.x,
        "y": pose.y,
        "yaw": pose.yaw,
        "confidence": sighting.confidence,
        "last_seen_s": sighting.last_seen_s,
        "sightings": sighting.count,
        "belief": sighting.belief,
        "believed_s": sighting.last_seen_s,
    }
