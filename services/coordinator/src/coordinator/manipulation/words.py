"""What a person is told of how a fetch ended; made of types, read by nobody but people."""

from contracts.manipulation import FetchCause, FetchEnd


def told(end: FetchEnd, cause: FetchCause | None, thing: str) -> str:
    """One sentence. `thing`: as it was asked for, "red bottle"."""
    why = f": {cause.sentence}" if cause is not None else ""
    match end:
        case FetchEnd.DELIVERED:
            return f"I have handed over the {thing}."
        case FetchEnd.PLACED:
            return f"I have put down the {thing}."
        case FetchEnd.NOT_TAKEN:
            return f"I found the {thing}, but could not take it{why}."
        case FetchEnd.NOT_BROUGHT:
            return f"I have the {thing}, but could not bring it{why}."
        case FetchEnd.STOPPED:
            return "Stopped by the emergency stop; my arm holds what it holds."
        case FetchEnd.CANCELED:
            return "Cancelled; my arm stays where it is."
