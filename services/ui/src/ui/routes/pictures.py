"""Pictures the page shows once: the map, the moments of a timeline, the crops that were voted on."""

import asyncio
from typing import Annotated, Any, Final

from fastapi import APIRouter, Path, Query
from fastapi.responses import Response

from mesh.access import Role, requires_role
from mesh.errors import NotFoundError
from ui import thumbnails
from ui.annotated_picture import annotated
from ui.routes.deps import DeskDep

router = APIRouter(tags=["pictures"])

PNG: Final[dict[int | str, dict[str, Any]]] = {200: {"content": {"image/png": {}}}}
JPEG: Final[dict[int | str, dict[str, Any]]] = {200: {"content": {"image/jpeg": {}}}}
LASTING: Final = {"Cache-Control": "private, max-age=86400"}

MissionId = Annotated[str, Path(min_length=1, max_length=64)]
Number = Annotated[int, Path(ge=0, le=2**53)]


@router.get("/live/map.png", responses=PNG, response_class=Response)
@requires_role(Role.VIEWER)
async def map_png(desk: DeskDep, v: Annotated[str, Query(max_length=40)] = "") -> Response:
    """The known part of the map, one pixel a cell; the page asks for it once a version (`?v=`)."""
    picture = await desk.map_picture()
    lasting = LASTING["Cache-Control"] if v == picture.version else "no-cache"
    headers = {"ETag": f'"{picture.version}"', "Cache-Control": lasting}
    return Response(picture.png, media_type="image/png", headers=headers)


@router.get("/album/{mission_id}/{event_id}", responses=JPEG, response_class=Response)
@requires_role(Role.VIEWER)
async def moment(mission_id: MissionId, event_id: Number, desk: DeskDep) -> Response:
    """What the camera saw when this happened, with its boxes. 404 when it is no longer kept."""
    shown = desk.event_pictures.get(mission_id, event_id)
    if shown is None:
        raise NotFoundError("no picture of that moment is kept")
    return Response(await asyncio.to_thread(annotated, shown), media_type="image/jpeg", headers=LASTING)


@router.get("/crops/{mission_id}/{number}", responses=JPEG, response_class=Response)
@requires_role(Role.VIEWER)
async def crop(mission_id: MissionId, number: Number, desk: DeskDep) -> Response:
    """The crop that was voted on, from the coordinator's records."""
    return Response(await desk.missions.picture(mission_id, number), media_type="image/jpeg", headers=LASTING)


@router.get("/things/{object_id}", responses=JPEG, response_class=Response)
@requires_role(Role.VIEWER)
async def thing(object_id: Annotated[int, Path(ge=0, le=2**53)], desk: DeskDep) -> Response:
    """A remembered thing as it was last seen; the page asks for it once a sighting (`?v=`). 404 where it was not."""
    found = desk.thumbnails.get(object_id)
    if found is None:
        raise NotFoundError("no picture of that thing is kept")
    return Response(await asyncio.to_thread(thumbnails.cropped, found), media_type="image/jpeg", headers=LASTING)
