"""What OpenAPI says of who may: `security` and `x-required-role` of each operation."""

from collections.abc import Callable
from typing import Any, Final

from fastapi import FastAPI

from mesh.access.policies import route_policies

SCHEME: Final = {
    "type": "http",
    "scheme": "bearer",
    "description": "A key of `atom keys make`; a service without keys asks for none, and listens on its machine alone.",
}


def with_roles(app: FastAPI) -> Callable[[], dict[str, Any]]:
    """In place of `app.openapi`."""
    plain = app.openapi

    def openapi() -> dict[str, Any]:
        schema = plain()
        schema.setdefault("components", {})["securitySchemes"] = {"key": SCHEME}
        for policy in route_policies(app.routes):
            operation = schema["paths"].get(policy.path, {}).get(policy.method.lower())
            if operation is not None:
                operation["security"] = [] if policy.role is None else [{"key": []}]
            if operation is not None and policy.role is not None:
                operation["x-required-role"] = policy.role.value
        return schema

    return openapi
