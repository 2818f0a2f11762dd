"""Who may what: a policy a route (`requires_role`, `public`), the middleware that holds to it, and the credentials."""

from contracts.access import Principal, Role
from mesh.access.middleware import AuthorizationMiddleware, current_principal, principal_of
from mesh.access.policies import NotDeclaredError, public, requires_role

__all__ = [
    "AuthorizationMiddleware",
    "NotDeclaredError",
    "Principal",
    "Role",
    "current_principal",
    "principal_of",
    "public",
    "requires_role",
]
