"""results.json as junit.xml, for tools that read such files. Reads JSON only."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from grader.report.results import Row

# XML has no way at all to write most control characters, nor half a surrogate pair.
_UNWRITABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_ELEMENTS = {
    "failed": "failure",
    "crashed": "failure",
    "timeout": "failure",
    "error": "error",
    "todo": "skipped",
    "blocked": "skipped",
}


def as_xml(content: Row) -> str:
    """Return the text of junit.xml: a suite per TP, a case per check."""
    suites = ElementTree.Element("testsuites", name=_text(content["submission"]["name"]))
    for tp in sorted({each["tp"] for each in content["checks"]}):
        suites.append(_suite(tp, [each for each in content["checks"] if each["tp"] == tp]))
    ElementTree.indent(suites, " ")
    text = ElementTree.tostring(suites, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _suite(tp: int, checks: list[Row]) -> ElementTree.Element:
    suite = ElementTree.Element("testsuite", name=f"TP{tp}", tests=str(len(checks)))
    for name, element in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        count = sum(_ELEMENTS.get(each["outcome"]) == element for each in checks)
        suite.set(name, str(count))
    suite.set("time", f"{sum(each['seconds'] for each in checks):.3f}")
    for each in checks:
        suite.append(_case(each))
    return suite


def _case(check: Row) -> ElementTree.Element:
    group = f"{check['exercise']}.{check['function']}"
    case = ElementTree.Element("testcase", classname=group, name=_text(check["title"]))
    case.set("time", f"{check['seconds']:.3f}")
    element = _ELEMENTS.get(check["outcome"])
    if element:
        problem = ElementTree.SubElement(case, element, message=_text(check["message"]))
        if element != "skipped":
            problem.set("type", check["outcome"])
            problem.text = _text(check["hint"])
    return case


def _text(text: str) -> str:
    return _UNWRITABLE.sub("\N{REPLACEMENT CHARACTER}", text)
