"""Dates as Moodle writes them for persons, in French or in English."""

from __future__ import annotations

import re
from datetime import datetime

_MONTHS = (
    ("january", "janvier"),
    ("february", "février"),
    ("march", "mars"),
    ("april", "avril"),
    ("may", "mai"),
    ("june", "juin"),
    ("july", "juillet"),
    ("august", "août"),
    ("september", "septembre"),
    ("october", "octobre"),
    ("november", "novembre"),
    ("december", "décembre"),
)
_TIME = r"(?P<hour>\d{1,2})[:h](?P<minute>\d{2})(?:\s*(?P<half>[AaPp][Mm]))?"
_DAY_FIRST = re.compile(
    rf"(?P<day>\d{{1,2}})(?:er)?\s+(?P<month>[^\W\d]+)\s+(?P<year>\d{{4}})[^\d]+{_TIME}"
)
_MONTH_FIRST = re.compile(
    rf"(?P<month>[^\W\d]+)\s+(?P<day>\d{{1,2}}),?\s+(?P<year>\d{{4}})[^\d]+{_TIME}"
)
_ISO = re.compile(
    r"(?P<year>\d{4})-(?P<month>\d{2})-(?P<day>\d{2})"
    r"[ T](?P<hour>\d{2}):(?P<minute>\d{2})(?P<half>)"
)


def read_moment(text: str) -> datetime | None:
    """Return the first date in a text; None when there is none that is understood."""
    found = _DAY_FIRST.search(text) or _MONTH_FIRST.search(text) or _ISO.search(text)
    if not found:
        return None
    name = found["month"].casefold()
    month = next((k for k, names in enumerate(_MONTHS, 1) if name in names), 0)
    hour = int(found["hour"])
    if found["half"]:
        hour = hour % 12 + (12 if found["half"].casefold() == "pm" else 0)
    try:
        month = int(name) if name.isdecimal() else month
        return datetime(int(found["year"]), month, int(found["day"]), hour, int(found["minute"]))
    except ValueError:
        return None


def as_iso(moment: datetime) -> str:
    """Return a date as every reader of dates understands it."""
    return moment.strftime("%Y-%m-%d %H:%M")
