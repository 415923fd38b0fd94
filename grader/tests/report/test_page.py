"""report.html, from the content of results.json alone."""

from __future__ import annotations

import re
from collections.abc import Callable
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from grader.course.texts import LANGUAGES, Texts
from grader.report import page
from grader.report.page import markup
from grader.tests.support.reports import HOSTILE, PNG, every_outcome

VOID = {"meta", "img", "rect", "link", "br", "input"}


class Elements(HTMLParser):
    """The elements of a page, in order, with their attributes and text; tags must be balanced."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element without content."""
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        """Hold that the innermost element is the one that ends."""
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Note text."""
        self.texts.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Return the attributes of the elements of a kind."""
        return [attributes for name, attributes in self.found if name == tag]


@pytest.fixture
def whole(tmp_path: Path) -> Callable[..., str]:
    """Return a function that makes the page of a report in which everything happens."""

    def make(language: str = "fr", **change: Any) -> str:
        return page.render({**every_outcome(language, tmp_path), **change}, tmp_path)

    return make


Make = Callable[..., str]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_page_needs_nothing_else(whole: Make, language: str) -> None:
    """Its pictures are in it, its style and script too; it names no address at all."""
    html = whole(language)
    elements = Elements(html)
    assert elements.all("html") == [{"lang": language}]
    sources = [each["src"] or "" for each in elements.all("img")]
    assert len(sources) >= 2
    assert all(each.startswith("data:image/png;base64,") for each in sources)
    assert [each for each in elements.all("script") if each] == []
    assert elements.all("link") == elements.all("iframe") == []
    links = [each["href"] or "" for each in elements.all("a")]
    assert links
    targets = {attributes.get("id") for _, attributes in elements.found}
    assert {each[1:] for each in links} <= targets
    assert "http:" not in html
    assert "https:" not in html


def test_every_picture_and_table_has_words(whole: Make) -> None:
    """For who listens to the page: alternative texts, heads of columns and rows, one title."""
    elements = Elements(whole())
    assert all(each.get("alt") for each in elements.all("img"))
    assert all(each.get("scope") in ("col", "row") for each in elements.all("th"))
    assert len(elements.all("h1")) == len(elements.all("main")) == 1
    assert all(each.get("aria-hidden") == "true" for each in elements.all("svg"))
    levels = [int(tag[1]) for tag, _ in elements.found if re.fullmatch("h[1-6]", tag)]
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_outcomes_are_words_and_signs(whole: Make) -> None:
    """Each with a sign of its own, so that nothing rests on a colour."""
    html = whole()
    signs = dict(re.findall(r'class="outcome (\w+)"><span[^>]*>(.)</span>', html))
    to_write = {"todo", "not_compiled"}  # the same: nobody has been told that it is wrong
    assert set(signs) == {"passed", "failed", "crashed", "timeout", "blocked", "error"} | to_write
    assert len(set(signs.values())) == len(signs) - 1
    for name in signs:
        assert f"</span> {Texts('fr').say(f'outcome.{name}')}</span>" in html


def test_hints_are_folded_until_they_are_asked_for(whole: Make) -> None:
    """Below the question, the more precise one first, with words for what is inside."""
    hints = [{"level": 2, "text": "Look <here>."}, {"level": 3, "text": "Write that."}]
    checks = [
        {**each, "hints": hints} if each["outcome"] == "failed" else {**each, "hints": []}
        for each in every_outcome("en")["checks"]
    ]
    html = whole("en", checks=checks)
    folded = (
        r'<details class="more"><summary>([^<]*)</summary><p class="hint">([^<]*)</p></details>'
    )
    wanted = [("A hint", "Look &lt;here&gt;."), ("The most direct hint", "Write that.")]
    assert re.findall(folded, html) == wanted * sum(each["outcome"] == "failed" for each in checks)


def test_where_a_picture_differs_stands_above_it(whole: Make) -> None:
    """In words, once for each check with pictures, which show how alike they are, and what for."""
    html = whole("en")
    told = "The differences are in one place: at the top left (12 pixels). (The grey boxes"
    assert html.count(told) == html.count('<div class="pictures"') > 0
    assert html.count("it does not count towards the points.</figcaption>") == html.count(told)


def test_names_of_c_are_not_broken_across_lines() -> None:
    """A browser would break r->tmax behind its dash; what is around stays text."""
    said = markup.told("Après f(a < b), r->tmax et out->orig.x valent 3 ; <i>", "fr")
    assert said == (
        'Après f(a &lt; b), <span class="whole">r-&gt;tmax</span> et'
        ' <span class="whole">out-&gt;orig.x</span> valent 3\u202f; &lt;i&gt;'
    )
    assert ".whole { white-space: nowrap; }" in (page.TEMPLATES / "style.css").read_text("utf-8")


def test_what_a_submission_wrote_is_inert(whole: Make) -> None:
    """Its tags are text, its controls and changes of direction are spelled out."""
    html = whole()
    assert "<img src=x" not in html
    assert HOSTILE.count("</script>") == 1
    assert html.count("</script>") == 1
    assert "\x1b" not in html
    assert "\u202e" not in html
    assert "&lt;U+001B&gt;" in html
    assert "&lt;U+202E&gt;" in html


def test_only_our_own_style_and_script_are_allowed(whole: Make) -> None:
    """The policy holds their hashes; nothing in the page has a style or a handler of its own."""
    elements = Elements(whole())
    (policy,) = [each["content"] or "" for each in elements.all("meta") if "http-equiv" in each]
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert "unsafe" not in policy
    for _, attributes in elements.found:
        assert "style" not in attributes
        assert not any(name.startswith("on") for name in attributes)


def test_a_crash_shows_its_line_and_its_program(whole: Make) -> None:
    """The line is marked with a sign; the program has its comment in the language."""
    elements = Elements(whole())
    text = "".join(elements.texts)
    assert "▶   3 f(<U+001B>)<img src=x" in text
    assert 'return 0; /* attendu : "<1>" */' in text
    assert re.search(r"«\u00a0make try CASE=tp1\.\w+\.\w+\u00a0»", text)


def test_pictures_are_taken_from_the_folder_only(tmp_path: Path) -> None:
    """A path that leaves it, or what is no picture, gives none; a sentence says so."""
    (tmp_path / "in").mkdir()
    (tmp_path / "out.png").write_bytes(PNG)
    (tmp_path / "in" / "text.png").write_bytes(b"text")
    (tmp_path / "in" / "large.png").write_bytes(PNG + bytes(page.MAX_PICTURE))
    for path in ("../out.png", "/etc/passwd", "none.png", "text.png", "large.png", "\0", ".", ""):
        assert page.data_uri(tmp_path / "in", path) == ""
    (tmp_path / "in" / "right.png").write_bytes(PNG)
    assert page.data_uri(tmp_path / "in", "right.png").startswith("data:image/png;base64,iVBO")
    assert "relancez make grade" in page.render(every_outcome(), tmp_path)


def test_french_typography_is_for_sentences_only() -> None:
    """Spaces that do not break, and none of them in what a program wrote."""
    assert markup.typeset("Un « mot » : oui ; non ?", "fr") == (
        "Un «\u00a0mot\u00a0»\u00a0: oui\u202f; non\u202f?"
    )
    assert markup.typeset("2,5 / 4", "fr") == "2,5\u00a0/\u00a04"
    assert markup.typeset("word : word", "en") == "word : word"
    assert markup.typeset(markup.verbatim("a ? b : c"), "fr") == "a ? b : c"
    assert markup.typeset(3, "fr") == 3


def test_c_is_marked_and_escaped() -> None:
    """Line by line, each balanced in itself."""
    lines = markup.c_lines('/* a\nb */ if (x < 1) { y = "</pre>"; }\n\n')
    assert lines[0] == '<span class="cm">/* a</span>'
    assert '<span class="k">if</span> (x &lt; <span class="mi">1</span>)' in lines[1]
    assert "&lt;/pre&gt;" in lines[1]
    assert len(lines) == 2


def test_files_history_and_changes_are_told(whole: Make) -> None:
    """Which files, how old, what became of the runs before."""
    run = {"graded_at": "2026-03-02T10:30:00+01:00", "score": 1.5, "max_score": 100, "bonus": 0}
    change = {"exercise": "TP2.4", "kind": "fixed", "points": 8, "was": 0}
    html = whole(history=[run, {**run, "score": 9.5}], changes=[change])
    text = "".join(Elements(html).texts)
    assert "TP2.4 est maintenant juste." in text
    assert "02/03/2026, 10:30" in text
    assert text.index("9,5\u00a0/\u00a0100") < text.index("1,5\u00a0/\u00a0100")
    assert "rendu/\ufffd/main.c" in text
    assert "Évaluations précédentes" not in whole()


def test_the_page_is_the_same_without_kept_templates(
    whole: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where compiled templates cannot be kept they are compiled each time."""
    kept = whole()
    monkeypatch.setattr("grader.report.page.os.access", lambda path, mode: False)
    assert whole() == kept
