"""index.html of a class in a real browser: from a file, inert, sortable, without any request."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grader.batch import class_page
from grader.batch.records import Candidate, Graded, Mark, Member
from grader.course.exercises import load
from grader.course.message import Message
from grader.course.settings import Course
from grader.course.texts import Texts
from grader.tests.browser.test_report_page import DESK, PHONE, browser, opened
from grader.tests.support.reports import HOSTILE, PNG

__all__ = ["browser"]  # the fixture
RULES = Course("fr", "c", (1, 2, 3, 4, 5), count_closed=False)
SHARES = (1.0, 0.55, 0.0)


def summary(share: float) -> dict[str, Any]:
    """Return the summary of a result in which that share of every exercise is earned."""
    outcome = {1.0: "passed", 0.0: "todo"}.get(share, "crashed")
    rules = load()
    return {
        "tps": [{"tp": tp, "score": 20 * share, "max_score": 20} for tp in rules.tps],
        "bonus": 0.0,
        "incomplete": False,
        "learnt": [],
        "compiles": share > 0,
        "exercises": {
            each.id: [outcome, each.points / 100 * share, each.points / 100]
            for each in rules.exercises
        },
        "checks": dict.fromkeys(rules.checks(), outcome),
        "mistakes": ["far_root", HOSTILE],
    }


def page(names: bool, folder: Path, language: str = "fr") -> str:
    """Return the page of a class of thirty, one of whom has a hostile name."""
    marks, graded = [], {}
    for number in range(30):
        share = SHARES[number % 3]
        name = HOSTILE if number == 1 else f"Élève {number:02d}"
        key = f"élève {number:02d}"
        graded[key] = Graded(Candidate(key, key, Path("x")), summary(share), seconds=number / 7)
        remark = (Message("batch.several", {"places": HOSTILE}),) if number % 7 == 0 else ()
        mark = None if number == 3 else 20 * share
        marks.append(Mark(Member(name, submission=key), mark, why=remark, error=number == 3))
    hidden = {key: f"K{number:03d}" for number, key in enumerate(reversed(graded), 1)}
    shown = None if names else hidden
    return class_page.render(marks, graded, RULES, shown, Texts(language), folder)


@pytest.fixture
def address(tmp_path: Path) -> str:
    """Write the page with names; return its address."""
    path = tmp_path / "l'été" / class_page.NAME
    path.parent.mkdir()
    path.write_text(page(True, tmp_path), encoding="utf-8")
    return path.as_uri()


@pytest.mark.parametrize("size", [PHONE, DESK], ids=["phone", "desk"])
def test_nothing_acts_and_nothing_sticks_out(
    browser: Any, address: str, size: tuple[int, int]
) -> None:
    """Names are text; no request, no complaint, no sideways scrolling: remarks are within reach."""
    tab = opened(browser, address, size)
    assert tab.evaluate("document.querySelectorAll('main img').length") == 0
    assert "<img src=x onerror=alert(1)>" in tab.inner_text(".class")
    width = tab.evaluate("document.documentElement.scrollWidth")
    assert (width, tab.complaints) == (size[0], [])
    right = "each => each.getBoundingClientRect().right"
    assert 0 < tab.locator(".class td.why").first.evaluate(right) <= size[0]
    tab.close()


def column(tab: Any, number: int) -> list[str]:
    """Return the texts of a column of the table of people."""
    cells = tab.locator(f".class tbody tr:not([hidden]) > :nth-child({number})")
    return [text.strip() for text in cells.all_inner_texts()]


def test_the_table_is_sorted_and_filtered(browser: Any, address: str) -> None:
    """By numbers, up then down, what is missing last; words in any case, accents or not."""
    tab = opened(browser, address, DESK)
    button = tab.locator(".class thead button").nth(1)
    button.click()
    marks = column(tab, 2)
    assert marks == ["0"] * 10 + ["11"] * 10 + ["20"] * 9 + ["-"]
    button.click()
    assert column(tab, 2) == ["20"] * 9 + ["11"] * 10 + ["0"] * 10 + ["-"]
    tab.fill(".filter input", "ELEVE 29")
    assert column(tab, 1) == ["Élève 29"]
    assert tab.locator(".filter [role=status]").inner_text().strip() == "1 / 30"
    assert tab.complaints == []
    tab.close()


def test_without_names_nothing_tells_who(browser: Any, tmp_path: Path) -> None:
    """Neither names, nor links to pages that are called by them, nor remarks."""
    (tmp_path / "élève 04" / "gallery").mkdir(parents=True)
    (tmp_path / "élève 04" / "gallery" / "drawing.png").write_bytes(PNG)
    path = tmp_path / class_page.NAME
    path.write_text(page(False, tmp_path, "en"), encoding="utf-8")
    text = path.read_text(encoding="utf-8")
    assert "lève" not in text
    assert "students/" not in text
    tab = opened(browser, path.as_uri(), DESK)
    assert column(tab, 1)[:2] == ["K001", "K002"]
    assert tab.locator(".gallery figcaption").all_inner_texts() == ["Drawing: K026"]
    assert tab.locator(".gallery img").evaluate("each => each.naturalWidth") == 32
    assert tab.complaints == []
    tab.close()
