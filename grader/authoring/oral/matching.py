"""Finding, in a student's own code, the line that a known mistake would change."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from grader.authoring.oral import rules
from grader.authoring.oral.records import Change, Place
from grader.authoring.oral.rules import Rule, RuleMark
from grader.authoring.oral.tokens import FunctionTokens, Token, functions
from grader.authoring.specimens.mistakes import Mistake
from grader.course import exercises
from grader.intake.records import Submission

Binding = Mapping[str, tuple[Token, ...]]
_TIGHT_AFTER = ("(", "[", ".", "->", "!")
_TIGHT_BEFORE = (")", "]", ",", ";", ".", "->", "[", "++", "--")
_BINARY = (*"=*/+-<>?:%", "&&", "||", "<=", ">=", "==", "!=", "+=", "-=")
_ENDS = (";", "{", "}")
_CAST = ("float", "int", "double", "void")
LARGEST = 5000  # tokens of a body that is looked into
LONGEST = 80  # tokens that one free name may stand for
MOST_LINES = 3  # of a question, before and after


def changes(submission: Submission, mistake: Mistake) -> list[Change]:
    """Return the changes by which a mistake can be put into a submission, the surest first."""
    texts = {name: _text(content) for name, content in submission.files.items()}
    parsed = {name: functions(text) for name, text in texts.items() if name.endswith(".c")}
    names = exercises.load().exercise(mistake.exercise).functions
    found: dict[str, Change] = {}
    places = [(file, function) for file, own in parsed.items() for function in _reached(names, own)]
    for rule in rules.of(mistake):
        for file, function in places:
            for change in _in_function(rule, file, texts[file], function):
                found.setdefault(f"{file}{change.content}", change)
    return list(found.values())


def _text(content: bytes) -> str:
    return content.decode("utf-8", errors="surrogateescape")


def _reached(names: Sequence[str], own: Mapping[str, FunctionTokens]) -> Iterator[FunctionTokens]:
    """Yield the functions of these names in a file, then the helpers that they call there."""
    graded = {name for each in exercises.load().exercises for name in each.functions}
    waiting, seen = [name for name in names if name in own], set(names)
    while waiting:
        function = own[waiting.pop(0)]
        if len(function.body) > LARGEST:
            continue
        yield function
        called = {each.text for each in function.body if each.text in own} - graded - seen
        seen |= called
        waiting += sorted(called)


def _in_function(rule: Rule, file: str, text: str, function: FunctionTokens) -> Iterator[Change]:
    """Yield the changes that a rule makes in a function; none when it fits at several places."""
    fixed = _parameters(rule, function)
    fits = []
    for start in range(len(function.body)):
        for spans, bound in _fits(rule.marks, function, start, fixed):
            fits.append((spans, bound))
            break
    if len(fits) == 1:
        change = _change(rule, file, text, function, *fits[0])
        if change:
            yield change


def _parameters(rule: Rule, function: FunctionTokens) -> Binding:
    """Return what stands for the reference's parameters in the student's own definition."""
    names = exercises.load().exercise(rule.mistake.exercise).functions
    if function.name not in names or len(rule.parameters) != len(function.parameters):
        return {}
    pairs = zip(rule.parameters, function.parameters, strict=True)
    return {ours: (Token(theirs, theirs, "name", 0, 0),) for ours, theirs in pairs}


# ---- The pattern --------------------------------------------------------------------------------


def _fits(
    marks: Sequence[RuleMark], function: FunctionTokens, at: int, bound: Binding
) -> Iterator[tuple[list[tuple[int, int]], Binding]]:
    """Yield how a pattern fits a body from a place on: the span of each mark, and what is free."""
    if not marks:
        yield [], bound
        return
    mark = marks[0]
    for end in _ends(mark, function, at):
        now = _bind(mark, function.body[at:end], bound)
        if now is not None:
            for spans, after in _fits(marks[1:], function, end, now):
                yield [(at, end), *spans], after


def _ends(mark: RuleMark, function: FunctionTokens, at: int) -> Sequence[int]:
    """Return where the mark may end that begins at a place: the longest first."""
    row = function.body
    if at >= len(row):
        return ()
    if not mark.free:
        return (at + 1,) if row[at].key == mark.token.key else ()
    if at > 0 and row[at - 1].text in (".", "->"):
        return ()
    return _operand(function, at)[::-1]


def _operand(function: FunctionTokens, at: int) -> list[int]:
    """Return where the operand that begins at a place may end: after each of its parts."""
    row = function.body
    if row[at].kind in ("name", "number"):
        ends = [at + 1]
    elif row[at].text == "(":
        ends = [function.closed[at] + 1]
    else:
        return []
    if row[at].text in ("return", "if", "for", "while", "else"):
        return []
    while ends[-1] < min(len(row) - 1, at + LONGEST):
        k = ends[-1]
        if row[k].text in (".", "->") and row[k + 1].kind == "name":
            ends.append(k + 2)
        elif row[k].text in "([":
            ends.append(function.closed[k] + 1)
        else:
            break
    return [end for end in ends if end - at <= LONGEST]


def _bind(mark: RuleMark, part: Sequence[Token], bound: Binding) -> Binding | None:
    """Return the free names with one more; None when it stands for something else already."""
    if not mark.free:
        return bound
    keys = [each.key for each in part]
    if mark.free in bound:
        return bound if [each.key for each in bound[mark.free]] == keys else None
    if any([each.key for each in other] == keys for other in bound.values()):
        return None
    return {**bound, mark.free: tuple(part)}


# ---- The change ---------------------------------------------------------------------------------


def _change(
    rule: Rule,
    file: str,
    text: str,
    function: FunctionTokens,
    spans: Sequence[tuple[int, int]],
    bound: Binding,
) -> Change | None:
    """Return a rule's change where it fits; None when it brings in names that are not there."""
    changed = [span for mark, span in zip(rule.marks, spans, strict=True) if mark.changed]
    if not changed or any(each.free and each.free not in bound for each in rule.new):
        return None
    row = function.body
    start, end = row[changed[0][0]].start, row[changed[-1][1] - 1].end
    part = [token for mark in rule.new for token in bound.get(mark.free, (mark.token,))]
    content = _put(text, start, end, part)
    if content == text:
        return None
    lines, after = text.split("\n"), content.split("\n")
    first, last = (text.count("\n", 0, each) + 1 for each in (start, end))
    old, new = lines[first - 1 : last], after[first - 1 : last + len(after) - len(lines)]
    if len(old) > MOST_LINES or len(new) > MOST_LINES:
        return None
    place = Place(file, first, function.name, "\n".join(old))
    return Change(rule.mistake, place, "\n".join(filter(str.strip, new)), content)


def _put(text: str, start: int, end: int, part: Sequence[Token]) -> str:
    """Return the text with tokens in the place of a part of it, and a space where one is due."""
    before, after = text[:start], text[end:]
    if not part and before[-1] in "([":
        return before + after.lstrip(" ")
    if not part:
        return (before.rstrip(" ") if after[0] in " ;,)]" else before) + after
    indent = re.match(r"[ \t]*", before[before.rfind("\n") + 1 :])
    new = spaced(part, indent[0] if indent else "")
    joins = re.search(r"[\w)\]]\s*$", before) is not None  # two operands, by an operator
    if part[0].text in _TIGHT_BEFORE:
        before = before.rstrip(" ")
    elif joins and part[0].text in _BINARY and before[-1] not in " \t":
        new = f" {new}"
    last = len(part) - 1
    if part[last].text == "!" or (_is_unary(part, last) and (last or not joins)):
        after = after.lstrip(" ")
    elif part[last].text in (*_BINARY, ",") and after[0] not in " \t\n":
        new = f"{new} "
    return before + new + after


def spaced(row: Sequence[Token], indent: str = "") -> str:
    """Return tokens as C, spaced as in the course's own code; `indent` begins further lines."""
    line, depth, block = "", 0, 0
    for k, token in enumerate(row):
        depth += (token.text in "([") - (token.text in ")]")
        block += (token.text == "{") - (token.text == "}")
        if k and row[k - 1].text in _ENDS and depth <= 0:
            line += f"\n{indent}{' ' * 4 * block}" if token.text != "{" else " "
        elif line and not _is_tight(row, k):
            line += " "
        line += token.text
    return line


def _is_tight(row: Sequence[Token], k: int) -> bool:
    """Say whether a token follows the one before it without a space."""
    token, before = row[k], row[k - 1]
    if before.text in _TIGHT_AFTER or token.text in _TIGHT_BEFORE or _is_unary(row, k - 1):
        return True
    is_cast = before.text == ")" and k > 2 and row[k - 2].text in _CAST and row[k - 3].text == "("
    if token.text == "(" and not is_cast:
        return before.kind == "name" and before.text not in ("return", "if", "for", "while")
    return is_cast


def _is_unary(row: Sequence[Token], k: int) -> bool:
    ahead = row[k - 1].text if k else ";"
    return row[k].text in ("-", "*", "&") and ahead in (*_BINARY, *_ENDS, *"(,[", "return")
