"""Who a browser is: for a name with its password or key, a cookie that is signed, expires, and ends with either."""

import asyncio
import hashlib
from typing import Final

from itsdangerous import BadSignature, URLSafeTimedSerializer
from pwdlib import PasswordHash
from pydantic import SecretStr
from starlette.requests import HTTPConnection
from starlette.responses import Response

from contracts.access import Principal
from mesh.access.credentials import CredentialStore
from mesh.access.rate_limit import FailureRateLimit
from mesh.errors import TooManyError

COOKIE: Final = "atom_session"
VERIFIED_AT_ONCE: Final = 2
"""64 MB each."""


class PageSessions:
    """Nothing is kept here: a cookie names its principal, and the credentials say each time what that is worth."""

    def __init__(self, key: SecretStr, lasts_s: int) -> None:
        """`key` is the page's own; whoever replaces it ends every session."""
        self._signed = URLSafeTimedSerializer(
            key.get_secret_value(), salt="atom session", signer_kwargs={"digest_method": hashlib.sha256}
        )
        self._lasts_s = lasts_s
        self._passwords = PasswordHash.recommended()
        self._nobodys = self._passwords.hash("")
        self._verifying = 0
        self.failures = FailureRateLimit()

    def authenticate(self, connection: HTTPConnection, credentials: CredentialStore) -> Principal | None:
        """As `mesh.access.AuthorizationMiddleware` asks for it."""
        try:
            name, begun_with = self._signed.loads(connection.cookies[COOKIE], max_age=self._lasts_s)
        except (KeyError, BadSignature, TypeError, ValueError):
            return None
        principal = credentials.by_name(str(name))
        return principal if principal is not None and begun_with == _mark(principal) else None

    async def log_in(self, name: str, secret: str, credentials: CredentialStore) -> Principal | None:
        """By the key, which needs no name, else by the password; a name that nobody has takes as long.

        Raises `TooManyError` while others' passwords are compared.
        """
        by_key = credentials.by_key(secret)
        if by_key is not None:
            return by_key if name in ("", by_key.name) else None
        principal = credentials.by_name(name)
        kept = principal.password if principal is not None else None
        if self._verifying >= VERIFIED_AT_ONCE:
            raise TooManyError("others are logging in")
        self._verifying += 1
        try:
            fits = await asyncio.to_thread(self._passwords.verify, secret, kept or self._nobodys)
        finally:
            self._verifying -= 1
        return principal if fits and kept is not None else None

    def begin(self, response: Response, principal: Principal, *, path: str, secure: bool) -> None:
        said = self._signed.dumps((principal.name, _mark(principal)))
        response.set_cookie(
            COOKIE, said, max_age=self._lasts_s, path=path, secure=secure, httponly=True, samesite="lax"
        )


def end(response: Response, *, path: str) -> None:
    response.delete_cookie(COOKIE, path=path, httponly=True, samesite="lax")


def _mark(principal: Principal) -> str:
    """Of the key and the password as they are: with another of either the session is over."""
    return hashlib.sha256(f"{principal.key_sha256} {principal.password}".encode()).hexdigest()[:16]
