"""report.html: results.json as one page that needs nothing else, for any browser. Reads JSON only.

The templates are pieces that other pages can be made of: `base.html` is the frame, `pieces.html`
has the parts.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import os
from pathlib import Path
from typing import Any

import jinja2
from jinja2 import Environment, FileSystemBytecodeCache, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader.course import exercises
from grader.course.texts import Texts
from grader.files import content_key
from grader.report.page import markup
from grader.report.results import Row
from grader.report.summary import Summary

NAME = "report.html"
TEMPLATES = Path(__file__).parent / "templates"
MAX_PICTURE = 2_000_000  # bytes
_PNG = b"\x89PNG\r\n\x1a\n"


def render(content: Row, folder: Path) -> str:
    """Return the page of the content of results.json, whose pictures are in a folder."""
    texts = Texts(content["language"])
    summary = Summary(content, texts)
    current = summary.next_exercise()
    return (
        environment(texts)
        .get_template("report.html")
        .render(
            content=content,
            summary=summary,
            tps=_tps(content, texts),
            current=current["id"] if current else "",
            picture=lambda path: data_uri(folder, path),
        )
    )


def environment(
    texts: Texts, own: Path = TEMPLATES, style: str = "", script: str = "script.js"
) -> Environment:
    """Return what the project's pages are made with, in a language.

    `own` holds a page's templates, which may extend ours, a `style` that comes behind ours, and a
    `script`. Whatever a template writes is made visible, typeset and escaped, unless it is Markup.
    """
    folders = list(dict.fromkeys([own, TEMPLATES]))
    styles = _text(TEMPLATES / "style.css") + (_text(own / style) if style else "")
    scripts = _text(next(path for each in folders if (path := each / script).is_file()))
    made = Environment(
        loader=FileSystemLoader(folders),
        bytecode_cache=_compiled(texts.language),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: markup.typeset(value, texts.language),
    )
    made.filters |= {"verbatim": markup.verbatim, "c": markup.c_lines}
    made.filters["told"] = lambda text: markup.told(text, texts.language)
    made.globals |= {
        "say": texts.say,
        "word": texts.get,
        "number": texts.number,
        "language": texts.language,
        "style": styles,
        "script": scripts,
        "policy": _policy(styles, scripts),
    }
    return made


def _compiled(language: str) -> FileSystemBytecodeCache | None:
    """Return where compiled templates are kept; None when that cannot be written.

    What is constant in them is typeset when they are compiled, in a language.
    """
    made_by = [jinja2.__version__, language, Path(markup.__file__).read_text(encoding="utf-8")]
    key = content_key(made_by)
    folder = exercises.ROOT / "build" / "cache" / "templates" / key
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return FileSystemBytecodeCache(str(folder)) if os.access(folder, os.W_OK) else None


def data_uri(folder: Path, path: str) -> str:
    """Return a picture as a URI that holds it; "" when it is not a PNG file of that folder."""
    try:
        place = (folder / path).resolve()
        if folder.resolve() not in place.parents or place.stat().st_size > MAX_PICTURE:
            return ""
        content = place.read_bytes()
    except (OSError, ValueError):
        return ""
    if not content.startswith(_PNG):
        return ""
    return f"data:image/png;base64,{base64.b64encode(content).decode()}"


def _text(path: Path) -> Markup:
    return Markup(path.read_text(encoding="utf-8"))


def _policy(style: str, script: str) -> str:
    """Return the page's Content-Security-Policy: our own style and script, nothing else at all."""

    def hashed(text: str) -> str:
        digest = hashlib.sha256(text.encode()).digest()
        return f"'sha256-{base64.b64encode(digest).decode()}'"

    return (
        f"default-src 'none'; img-src data:; style-src {hashed(style)}; "
        f"script-src {hashed(script)}; base-uri 'none'; form-action 'none'"
    )


def _tps(content: Row, texts: Texts) -> list[dict[str, Any]]:
    """Return the TPs that were judged: their title, score, and exercises with their checks."""
    scores = {each["tp"]: each for each in content["tps"]}
    checks: dict[str, list[Row]] = {}
    for each in content["checks"]:
        checks.setdefault(each["exercise"], []).append(each)
    found = []
    for tp in sorted({each["tp"] for each in content["exercises"]}):
        rows = [each for each in content["exercises"] if each["tp"] == tp]
        bonus = [each for each in rows if each["bonus"]]
        found.append(
            {
                "tp": tp,
                "title": texts.tp_title(tp),
                "score": scores.get(tp, {"score": 0, "max_score": 0}),
                "bonus": sum(each["points"] for each in bonus),
                "exercises": [{**each, "checks": checks.get(each["id"], [])} for each in rows],
            }
        )
    return found
