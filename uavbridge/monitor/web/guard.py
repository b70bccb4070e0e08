"""Who may see the page, and what the page may do.

Rule 1: without a token, this machine's own names alone, so that no foreign page can reach
us by a name that it points at loopback. Rule 2: a websocket is opened by our own page or by a
program, never by another site's page. Rule 3: with a token, nothing is served without it.
"""

from __future__ import annotations

from collections.abc import Iterable
from hmac import compare_digest
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from uavbridge.errors import ConfigError

COOKIE = "uavbridge_token"
SHORTEST_TOKEN = 12
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-cache",
}


def is_loopback(host: str) -> bool:
    """Whether a name or an address stands for this machine alone."""
    if host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def check_token(host: str, token: str | None) -> None:
    """Raise ConfigError for too short a token, and where others could come in without one."""
    if token is not None and len(token) < SHORTEST_TOKEN:
        raise ConfigError(f"--token: needs {SHORTEST_TOKEN} characters or more")
    if token is None and not is_loopback(host):
        raise ConfigError(f"--host: {host} can be reached by others; --token must be given")


class Guard:
    """An ASGI application around another.

    Args:
        app: what is guarded.
        token: None: loopback needs none.
    """

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        self._app, self._token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await receive()  # its connect
            await send({"type": "websocket.close", "code": 1008, "reason": "refused"})
        else:
            await refusal(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self._token is None and not is_loopback(_name(host)):
            return PlainTextResponse("this page is for this machine alone\n", 403)
        origin = headers.get("origin")
        if scope["type"] == "websocket" and origin is not None and urlsplit(origin).netloc != host:
            return PlainTextResponse("opened by another site's page\n", 403)
        if self._token is None:
            return None
        asked = parse_qs(scope.get("query_string", b"").decode("ascii", "replace")).get("token", [])
        if self._fits(asked) and scope["type"] == "http":
            # The token leaves the address bar and goes into a cookie that no script reads.
            response = RedirectResponse(scope["path"], 303)
            response.set_cookie(COOKIE, asked[0], httponly=True, samesite="strict")
            return response
        if self._fits([*asked, *_carried(headers)]):
            return None
        return PlainTextResponse("the token is missing or wrong: open /?token=...\n", 401)

    def _fits(self, given: Iterable[str]) -> bool:
        right = (self._token or "").encode()
        return any(compare_digest(one.encode("utf-8", "replace"), right) for one in given)


def _name(host: str) -> str:
    """The Host header without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _carried(headers: Headers) -> list[str]:
    """Tokens in the request's headers."""
    kind, _, bearer = headers.get("authorization", "").partition(" ")
    tokens = [bearer.strip()] if kind.lower() == "bearer" else []
    try:
        jar = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return tokens
    return [*tokens, jar[COOKIE].value] if COOKIE in jar else tokens


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            extra = [(name.encode(), value.encode()) for name, value in _HEADERS.items()]
            message["headers"] = [*message.get("headers", []), *extra]
        await send(message)

    return sending
