"""Who may what: a declaration a route (`needs`, `open_to_all`), the doors that hold to it, and the ring of keys."""

from contracts.access import Holder, Role
from mesh.access.declarations import NotDeclaredError, needs, open_to_all
from mesh.access.doors import Doors, who, who_now

__all__ = ["Doors", "Holder", "NotDeclaredError", "Role", "needs", "open_to_all", "who", "who_now"]
