"""Errors every service answers the same way, as problem+json.

MeshError
|- ForbiddenError           403  the role of who asks is too low for what was asked
|- NotFoundError            404  no such mission, goal, ...
|- ConflictError            409  not now: stopped, busy, already ended
|- UnprocessableError       422  well-formed, but it makes no sense here (goal outside the map)
|- TooLargeError            413  body over the limit
|- TooManyError             429  queue full
|- UnavailableError         503  a dependency is away; names it
|  `- ServiceTimeoutError   504  a dependency did not answer in time
`- UpstreamError            502  a dependency answered with a problem of its own
"""


class MeshError(Exception):
    """`detail` is for a person; `code` tells a program which refusal it is, where one acts on it."""

    status = 500
    title = "Internal error"

    def __init__(self, detail: str, *, code: str = "") -> None:
        super().__init__(detail)
        self.detail = detail
        self.code = code


class ForbiddenError(MeshError):
    status = 403
    title = "Not permitted"


class NotFoundError(MeshError):
    status = 404
    title = "Not found"


class ConflictError(MeshError):
    status = 409
    title = "Not now"


class UnprocessableError(MeshError):
    status = 422
    title = "Cannot be done"


class TooLargeError(MeshError):
    status = 413
    title = "Body too large"


class TooManyError(MeshError):
    status = 429
    title = "Too many requests"


class UnavailableError(MeshError):
    """`service` names the dependency that is away; `said` is the detail without that name."""

    status = 503
    title = "Dependency unavailable"

    def __init__(self, service: str, detail: str, *, code: str = "") -> None:
        super().__init__(f"{service}: {detail}", code=code)
        self.service = service
        self.said = detail


class ServiceTimeoutError(UnavailableError):
    status = 504
    title = "Dependency timed out"


class UpstreamError(MeshError):
    """Another service said no; `upstream_status` is its HTTP status, `said` what it said."""

    status = 502
    title = "Dependency refused"

    def __init__(self, service: str, upstream_status: int, detail: str, *, code: str = "") -> None:
        super().__init__(f"{service}: {detail}", code=code)
        self.service = service
        self.said = detail
        self.upstream_status = upstream_status
