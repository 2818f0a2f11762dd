"""Logging in and out: a plain form, answered with a cookie. Without keys there is nobody to be."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, Form
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from starlette.requests import Request

from contracts.access import PASSWORD_LENGTH_MAX
from mesh.access import Role, public, requires_role
from mesh.access.credentials import CredentialStore
from mesh.errors import TooManyError
from ui import plain
from ui.i18n import _
from ui.routes.deps import sessions_of
from ui.sessions import end

router = APIRouter(tags=["log in"])

LOG_IN_PATH: Final = "/login"
HOME: Final = "./"
"""Seen from there, below whatever path of a proxy."""
PAGE: Final[dict[str, Any]] = {"content": {"text/html": {}}}
SEE_OTHER: Final = 303
NOW: Final = {"Cache-Control": "no-store"}


@router.get(LOG_IN_PATH, response_class=HTMLResponse)
@public
async def form() -> Response:
    """The form."""
    return HTMLResponse(plain.log_in(""), headers=NOW)


@router.post(
    LOG_IN_PATH, status_code=SEE_OTHER, response_class=Response, responses={401: PAGE, 429: PAGE, SEE_OTHER: {}}
)
@public
async def log_in(
    request: Request,
    name: Annotated[str, Form(max_length=32)] = "",
    secret: Annotated[str, Form(max_length=PASSWORD_LENGTH_MAX)] = "",
) -> Response:
    """A cookie for a name with its password, or its key. 401 when they do not fit, 429 after too many that did not, and
    while others' passwords are compared.
    """
    credentials: CredentialStore | None = request.app.state.credentials
    sessions = sessions_of(request)
    if credentials is None or sessions is None:
        return RedirectResponse(HOME, SEE_OTHER)
    if not sessions.failures.hit(request):  # until it is known to be right: many asked at once are no more
        said = _("Too many attempts. Wait a minute.")
        return HTMLResponse(plain.log_in(said), 429, headers=NOW | {"Retry-After": "60"})
    try:
        principal = await sessions.log_in(name.strip(), secret, credentials)
    except TooManyError:
        sessions.failures.take_back(request)
        said = _("Others are logging in. Try again.")
        return HTMLResponse(plain.log_in(said), 429, headers=NOW | {"Retry-After": "1"})
    if principal is None:
        return HTMLResponse(plain.log_in(_("The name and the password do not fit.")), 401, headers=NOW)
    sessions.failures.take_back(request)
    answer = RedirectResponse(HOME, SEE_OTHER)
    scheme = request.headers.get("x-forwarded-proto", request.url.scheme)  # whoever makes it up harms his own cookie
    sessions.begin(answer, principal, path=_path(request), secure=scheme == "https")
    return answer


@router.post("/logout", status_code=SEE_OTHER, response_class=Response, responses={SEE_OTHER: {}})
@requires_role(Role.VIEWER)
async def log_out(request: Request) -> Response:
    """Takes the cookie back."""
    answer = RedirectResponse(LOG_IN_PATH.removeprefix("/"), SEE_OTHER)
    end(answer, path=_path(request))
    return answer


def _path(request: Request) -> str:
    """Of the cookie: below the proxy's path, so that no other page of its host gets it."""
    return request.scope.get("root_path", "") or "/"
