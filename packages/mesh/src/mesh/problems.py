"""RFC 9457 problem+json, the shape of every refusal."""

from fastapi.responses import JSONResponse

from contracts.problem import Problem


def problem(status: int, title: str, detail: str, instance: str = "", *, code: str = "") -> JSONResponse:
    body = Problem(title=title, status=status, detail=detail, instance=instance, code=code)
    return JSONResponse(body.model_dump(), status_code=status, media_type="application/problem+json")
