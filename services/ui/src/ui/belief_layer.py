"""The map's layer of what a search holds probable: cells as a picture, the view chosen next, the words beside them."""

import base64
import io
import math
from typing import Any

import numpy as np
from PIL import Image

from contracts.belief import ChosenView, NoBelief, SearchBelief
from geometry.probability_grids import Probabilities, ProbabilityGridError, corners, decode
from ui.i18n import N_, _
from ui.map_view import MapFrame, fit

Drawn = dict[str, Any]

STRENGTH_POWER = 1 / 3
"""A cell a thousand times less probable than the peak is still drawn, at a tenth of its strength."""
LEAST_TOLD = 0.0001
UNKNOWN = N_("What the search holds probable is not known just now.")
MISSING = {
    NoBelief.NOT_BEGUN: N_("No mission is under way."),
    NoBelief.ENDED: N_("The mission is over."),
    NoBelief.ANOTHER_RULE: N_("This mission does not search by probability."),
    NoBelief.NOTHING_CHOSEN: N_("The search has not chosen its first place yet."),
}


def belief(
    frame: MapFrame, told: SearchBelief | NoBelief | None, *, mission_id: str | None, map_id: str | None
) -> Drawn:
    """Of the mission and the home that are shown; of any other only the words that it is not known."""
    if isinstance(told, NoBelief):
        return _nothing(_(MISSING[told]))
    if told is None or told.mission_id != mission_id or (told.map_id is not None and told.map_id != map_id):
        return _nothing(_(UNKNOWN))
    try:
        cells = decode(told.grid)
    except ProbabilityGridError:
        return _nothing(_(UNKNOWN))
    side_cm = round(told.grid.resolution_m * 100)
    return {
        "png": f"data:image/png;base64,{base64.b64encode(_png(cells)).decode('ascii')}",
        "fit": fit(frame, corners(told.grid), told.grid.width, told.grid.height),
        "view": _view(frame, told.view) if told.view is not None else None,
        "absent": _("Not here: {share}", share=percent(told.absent)),
        "peak": _("{share} in {side} cm", share=percent(told.grid.peak), side=side_cm),
        "why": told.why,
    }


def percent(share: float) -> str:
    """Two digits that say something: 20 %, 3.1 %, 0.04 %."""
    if share < LEAST_TOLD:
        return "0 %" if share <= 0.0 else f"< {LEAST_TOLD * 100.0:.2f} %"
    digits = max(0, 1 - math.floor(math.log10(share * 100.0)))
    return f"{share * 100.0:.{min(digits, 2)}f} %"


def _nothing(why: str) -> Drawn:
    return {"png": "", "fit": [], "view": None, "absent": "", "peak": "", "why": why}


def _png(cells: Probabilities) -> bytes:
    """One pixel a cell, row 0 first; its strength is in the alpha, its colour is the page's."""
    peak = float(cells.max())
    strength = (cells / peak) ** STRENGTH_POWER if peak > 0.0 else cells
    alpha = np.rint(255.0 * strength).astype(np.uint8)
    out = io.BytesIO()
    Image.fromarray(np.stack([np.zeros_like(alpha), alpha], axis=2), "LA").save(out, "PNG", optimize=True)
    return out.getvalue()


def _view(frame: MapFrame, view: ChosenView) -> Drawn:
    x, y = frame.to_px(view.pose.x, view.pose.y)
    turns = [round(math.radians(frame.heading_deg(heading)), 3) for heading in view.headings]
    return {"at": [round(x, 1), round(y, 1)], "turns": turns}
