"""Plain pages for a browser that runs no script: what came of a STOP, who asks, and the button again. Pure."""

from html import escape
from typing import Final
from urllib.parse import urlsplit

from contracts.robot import EmergencyStopReply
from ui.i18n import _

BRIDGE_PORT: Final = 8004


def remedy(robot_bridge_url: str) -> str:
    """What stops the robot where this page cannot. ROBOT is its address, which this machine may not know."""
    port = urlsplit(robot_bridge_url).port or BRIDGE_PORT
    command = f"curl -X POST http://ROBOT:{port}/emergency-stop"
    return _("Use the robot's own button, or in a terminal: {command}, or: atom stop", command=command)


def stopped(reply: EmergencyStopReply) -> str:
    """The robot confirmed it."""
    if reply.first_zero_ms is None:
        return _page(_("The robot is stopped."), "")
    return _page(_("The robot is stopped."), _("First zero velocity after {ms:.1f} ms.", ms=reply.first_zero_ms))


def not_stopped(why: str, otherwise: str) -> str:
    """The robot did not confirm it; `otherwise` says what else stops it."""
    return _page(_("STOP DID NOT REACH THE ROBOT"), f"{why}. {_('Press again.')} {otherwise}")


def log_in(said: str) -> str:
    """Who are you? `said` is what was wrong with the last answer."""
    name, secret, enter = escape(_("Name (a key needs none)")), escape(_("Password or key")), escape(_("Log in"))
    form = f"""<form method="post" action="login">
<p><label>{name}<br><input name="name" autocomplete="username" autocapitalize="none"></label></p>
<p><label>{secret}<br><input name="secret" type="password" autocomplete="current-password" required></label></p>
<p><button class="enter" type="submit">{enter}</button></p></form>"""
    return _page(_("Who are you?"), said, form)


def _page(headline: str, text: str, form: str = "") -> str:
    title, press, back = escape(headline), escape(_("STOP")), escape(_("Back to the page"))
    way_on = form or f'<p><a href="./">{back}</a></p>'
    return f"""<!doctype html>
<html><head><title>{title}</title><meta name="viewport" content="width=device-width, initial-scale=1">
<style>
  body {{ font: 18px/1.5 system-ui, sans-serif; margin: 24px; }} h1 {{ font-size: 26px; }}
  button {{ font: inherit; font-weight: 700; padding: 14px 48px; border: 0; border-radius: 12px; }}
  button {{ color: #fff; background: #d11a1a; }} .enter {{ background: #1d56cf; }}
  input {{ font: inherit; padding: 8px; width: 100%; max-width: 380px; box-sizing: border-box; }}
</style></head>
<body><main><h1>{title}</h1><p>{escape(text)}</p>
{way_on}
<form method="post" action="stop?how=form"><button type="submit">{press}</button></form></main></body></html>
"""
