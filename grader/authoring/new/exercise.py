"""A new exercise with one function: contract, solution, suite, check, sentences, notebooks."""

from __future__ import annotations

import re
from collections import Counter

from grader.authoring.new import check as checks
from grader.authoring.new.check import MANIFEST, MESSAGES
from grader.authoring.new.edits import MARK, Edit, NewError, behind, created, read
from grader.authoring.translation import SOURCE
from grader.course.exercises import CORE, Exercise, Manifest
from grader.course.settings import COMPLETE
from grader.course.texts import Texts

HEADER = "core_c/exercises.h"
_ID = re.compile(r"TP([1-5])\.(B?)[1-7]")
_FUNCTION = re.compile(r"[a-z]\w*")
# What follows the exercise's title in the header, but for the French comments.
_ARGUMENT, _RETURNS = "  x  what it is", "Returns what."


def edits(name: str, function: str, rules: Manifest) -> list[Edit]:
    """Return the files of a new exercise, in the order to write them. Raises NewError."""
    tp = _verified(name, function, rules)
    own = [each for each in rules.exercises if each.tp == tp]
    file = Counter(each.file for each in own).most_common(1)[0][0]
    suite = f"{function}.any"
    return [
        _contract(name, function, own),
        _solution(name, function, file, own),
        _entry(name, function, file, suite, own),
        *(_messages(name, function, suite, each) for each in COMPLETE),
        *(_section(name, function, tp, each) for each in COMPLETE),
        _sentences(name),
    ]


def _verified(name: str, function: str, rules: Manifest) -> int:
    found = _ID.fullmatch(name)
    if not found:
        raise NewError(f"EXERCISE={name}: an id is like TP3.4, or TP3.B3 for a bonus")
    if name in {each.id for each in rules.exercises}:
        raise NewError(f"EXERCISE={name}: there is one already, in {MANIFEST}")
    if not _FUNCTION.fullmatch(function):
        raise NewError(f"FUNCTION={function}: name the function, such as fog_color")
    for header in sorted(CORE.glob("*.h")):
        if re.search(rf"\b{function}\(", header.read_text(encoding="utf-8")):
            raise NewError(f"FUNCTION={function}: core_c/{header.name} has one already")
    return int(found[1])


def _contract(name: str, function: str, own: list[Exercise]) -> Edit:
    tp = name[2]
    block = (
        f"\n/* {name} - {MARK} what {function} is, in a sentence; its parameters below.\n *\n"
        f" * {_ARGUMENT}\n *\n * {_RETURNS}\n"
        f" * Check: make grade TP={tp} K={function}\n */\nfloat {function}(float x);\n"
    )
    last = rf"^/\* {re.escape(own[-1].id)} - (?:.*\n)*?\w.*;\n"
    return Edit(HEADER, behind(HEADER, read(HEADER), last, block))


def _comment(name: str, function: str, language: str) -> str:
    """Return the contract in another language, beside the English one."""
    what = f"{name} - {MARK} what {function} is, in a sentence; its parameters below."
    english = f"{what}\n\n{_ARGUMENT}\n\n{_RETURNS}\nCheck: make grade TP={name[2]} K={function}"
    asked = Texts(language).say("new.contract", header=HEADER)
    return f"[[comment]]\nen = '''\n{english}'''\n{language} = '''\n{name} - {MARK} {asked}'''\n"


def _solution(name: str, function: str, file: str, own: list[Exercise]) -> Edit:
    path = f"reference/{file}"
    block = (
        f"\nfloat {function}(float x) {{\n    /* BEGIN SOLUTION {name}: return 0.f; */\n"
        f"    return x * x; /* {MARK} the solution; after the mark's colon, the stub's line */\n"
        "    /* END SOLUTION */\n}\n"
    )
    before = [each.id for each in own if each.file == file][-1]
    last = rf"^ +/\* BEGIN SOLUTION {re.escape(before)}\b(?:.*\n)*?\}}\n"
    return Edit(path, behind(path, read(path), last, block))


def _entry(name: str, function: str, file: str, suite: str, own: list[Exercise]) -> Edit:
    tp = name[2]
    block = f'''
[[exercise]]
id = "{name}"
tp = {tp}
functions = ["{function}"]
file = "{file}"
points = 100 # {MARK} hundredths of a point: the sum of the course's is 100 points, of bonuses 20
bonus = {str("B" in name).lower()}
section = "" # {MARK} of the handout
depends = [] # {MARK} the exercises whose functions a right one calls
[exercise.checks]
"tp{tp}.{suite}" = {{ weight = 1, compares = ["result"], suites = ["{suite}"] }}
{checks.suite_lines(suite, ["x"])}'''
    text = read(MANIFEST)
    last = rf'^id = "{re.escape(own[-1].id)}"\n(?:.+\n)*'
    return Edit(MANIFEST, behind(MANIFEST, text, last, block))


def _messages(name: str, function: str, suite: str, language: str) -> Edit:
    """Return the file of all that an exercise says in a language."""
    title = f'"{name}" = "" # {MARK} {Texts(language).say("new.exercise")}\n'
    tables = {"exercise": title, **checks.table_lines(f"tp{name[2]}.{suite}", language)}
    parts = [f"[{table}]\n{entry}" for table, entry in tables.items()]
    if language != SOURCE:
        parts.append(_comment(name, function, language))
    return created(f"{MESSAGES}/{language}/{function}.toml", "\n".join(parts))


def _section(name: str, function: str, tp: int, language: str) -> Edit:
    path, say = f"notebooks/{language}/TP{tp}.md", Texts(language).say
    block = (
        f"\n### `{function}`\n\n<!-- {MARK} {say('new.section')} -->\n\n"
        f'```python\ncheck("{name}")\n```\n'
    )
    text = behind(path, read(path), r'^check\("TP\d\.B?\d"\)\n```\n', block)
    row = f"| `{function}(x)` | {MARK} {say('new.takes')} | {MARK} {say('new.gives')} |\n"
    return Edit(path, behind(path, text, r"^\| `\w+\(.*\|\n", row))


def _sentences(name: str) -> Edit:
    note = f"{MARK} each sentence of the contract, and what breaks it (see worth.toml)"
    return created(f"reference/mistakes/{name}.toml", f"[sentences] # {note}\n")
