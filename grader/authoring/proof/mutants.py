"""How many small changes of the reference cost points: how sharp the checks are.

    python -m grader.authoring.proof.mutants [--jobs 2] [--limit N] [--functions NAME ...]

Each mutant (mutants_changes.py) is judged by the grader's own checks (mutants_judging.py). One that
costs no points is equivalent when its answers and pictures are the reference's, bit for bit, on
inputs that no check has (mutants_same.py), or for a reason written in
reference/mistakes/equivalent.toml. What is found is kept in build/prove/mutants/ by content: a run
that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path

from grader.authoring.proof import mutants_changes
from grader.authoring.proof.grades import judged_by
from grader.authoring.proof.mutants_changes import Mutant
from grader.authoring.proof.mutants_family import opened
from grader.authoring.proof.mutants_judging import caught_late, caught_soon
from grader.authoring.proof.mutants_same import answers_of, is_same
from grader.authoring.specimens.wrong import FOLDER as MISTAKES
from grader.course.exercises import ROOT, malformed, read_toml
from grader.files import write_whole

KEPT = ROOT / "build" / "prove" / "mutants"
REASONS = MISTAKES / "equivalent.toml"
FAMILY = 30  # mutants of a function that are compiled together, at most
NOT_BUILT = "not built"  # said in the place of a check


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant."""

    file: str
    function: str
    line: int
    kind: str
    before: str
    after: str
    caught_by: str  # a check; "" when none, NOT_BUILT when the compiler refuses it
    same: bool = False  # the reference's answers, bit for bit
    reason: str = ""  # why it is equivalent, where that is no proof but a sentence


@dataclass(frozen=True)
class Hint:
    """What an earlier run has found of a mutant."""

    caught_by: str = ""  # the check to begin with
    same: bool = False  # the reference's answers are still those that it gave


@dataclass(frozen=True)
class FunctionScore:
    """The mutants of one function."""

    function: str
    file: str
    total: int  # that compile
    equivalent: int
    caught: int

    @property
    def score(self) -> float:
        """The share caught of those that are not equivalent."""
        judged = self.total - self.equivalent
        return self.caught / judged if judged else 1.0


@dataclass(frozen=True)
class MutantsReport:
    """The mutants that compile, and what became of them."""

    total: int
    equivalent: int
    caught: int
    survivors: tuple[Verdict, ...]
    functions: tuple[FunctionScore, ...]
    equivalents: tuple[Verdict, ...]

    @property
    def score(self) -> float:
        """The share caught of those that are not equivalent."""
        judged = self.total - self.equivalent
        return self.caught / judged if judged else 1.0

    @property
    def worst(self) -> FunctionScore:
        """The function whose mutants are caught least."""
        return min(self.functions, key=lambda each: each.score)


def run(jobs: int = 1, limit: int | None = None, functions: Sequence[str] = ()) -> MutantsReport:
    """Judge every mutant, or `limit` of them spread over all, or those of some functions."""
    chosen = [
        each for each in mutants_changes.mutants() if not functions or each.function in functions
    ]
    if limit is not None:
        step = max(1, len(chosen) // limit)
        chosen = chosen[::step][:limit]
    return report(verdicts(chosen, jobs))


def verdicts(chosen: Sequence[Mutant], jobs: int) -> list[Verdict]:
    """Return what becomes of mutants, in their order; what is known already is not done again."""
    known = {each.id: verdict for each in chosen if (verdict := _kept(each))}
    waiting = [each for each in chosen if each.id not in known]
    for mutant, verdict in _judged(waiting, jobs):
        _keep(mutant, verdict)
        known[mutant.id] = verdict
    return [known[each.id] for each in chosen]


def report(found: Iterable[Verdict]) -> MutantsReport:
    """Add verdicts up; those that no compiler takes do not count."""
    reasons = read_reasons()
    counted = [_reasoned(each, reasons) for each in found if each.caught_by != NOT_BUILT]
    names = dict.fromkeys((each.file, each.function) for each in counted)
    functions = tuple(
        _score(function, file, [e for e in counted if (e.file, e.function) == (file, function)])
        for file, function in names
    )
    equivalents = tuple(each for each in counted if _is_equivalent(each))
    survivors = tuple(e for e in counted if not e.caught_by and not _is_equivalent(e))
    caught = len(counted) - len(equivalents) - len(survivors)
    return MutantsReport(len(counted), len(equivalents), caught, survivors, functions, equivalents)


def read_reasons(path: Path = REASONS) -> dict[tuple[str, str, str, str], str]:
    """Return the written reasons, by file, function, before and after. Raises ManifestError."""
    try:
        rows = read_toml(path).get("equivalent", [])
        return {
            (row["file"], row["function"], row["before"], row["after"]): row["reason"]
            for row in rows
        }
    except (KeyError, TypeError) as error:
        raise malformed(path, error) from error


def _reasoned(verdict: Verdict, reasons: dict[tuple[str, str, str, str], str]) -> Verdict:
    key = (verdict.file, verdict.function, verdict.before, verdict.after)
    if verdict.caught_by or verdict.same or key not in reasons:
        return verdict
    return Verdict(**{**asdict(verdict), "reason": reasons[key]})


def _is_equivalent(verdict: Verdict) -> bool:
    return not verdict.caught_by and (verdict.same or bool(verdict.reason))


def _score(function: str, file: str, own: Sequence[Verdict]) -> FunctionScore:
    equivalent = sum(map(_is_equivalent, own))
    caught = sum(bool(each.caught_by) for each in own)
    return FunctionScore(function, file, len(own), equivalent, caught)


# ---- Judging, and keeping what is found ---------------------------------------------------------


def _judged(waiting: Sequence[Mutant], jobs: int) -> Iterator[tuple[Mutant, Verdict]]:
    families = [
        (own[k : k + FAMILY], [_hint(each) for each in own[k : k + FAMILY]])
        for _, group in groupby(waiting, lambda each: (each.file, each.function))
        if (own := list(group))
        for k in range(0, len(own), FAMILY)
    ]
    if jobs == 1 or len(families) < 2:
        for chosen, hints in families:
            yield from zip(chosen, judge(chosen, hints, KEPT / "cache"), strict=True)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(families)), context) as pool:
        runs = {pool.submit(_in_own_cache, *each): each[0] for each in families}
        try:
            for done in as_completed(runs):
                yield from zip(runs[done], done.result(), strict=True)
        finally:
            pool.shutdown(cancel_futures=True)


def _in_own_cache(chosen: Sequence[Mutant], hints: Sequence[Hint]) -> list[Verdict]:
    """Judge mutants in a process that has others beside it, each with builds of its own."""
    name = multiprocessing.current_process().name.rpartition("-")[2]
    return judge(chosen, hints, KEPT / f"cache-{name}")


def judge(chosen: Sequence[Mutant], hints: Sequence[Hint], cache: Path) -> list[Verdict]:
    """Judge mutants of one function, each with a hint; `cache` is a folder of builds of one's own.

    Raises FamilyError.
    """
    found = [_verdict(each, NOT_BUILT) for each in chosen]
    with opened(chosen, cache) as (kit, building):
        for number, mutant in enumerate(building, 1):
            kit.choose(number)
            k = chosen.index(mutant)
            caught_by = caught_soon(kit, mutant, hints[k].caught_by)
            same = not caught_by and (hints[k].same or is_same(kit, mutant, cache))
            if not caught_by and not same:
                caught_by = caught_late(mutant, cache)
            found[k] = _verdict(mutant, caught_by, same)
    return found


def _verdict(mutant: Mutant, caught_by: str, same: bool = False) -> Verdict:
    told = {name: getattr(mutant, name) for name in ("file", "function", "line", "kind")}
    return Verdict(**told, before=mutant.before, after=mutant.after, caught_by=caught_by, same=same)


def _path(mutant: Mutant) -> Path:
    return KEPT / f"{mutant.id}.json"


def _read(mutant: Mutant) -> dict[str, object]:
    try:
        content = json.loads(_path(mutant).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return dict(content)


def _kept(mutant: Mutant) -> Verdict | None:
    """Return what is known of a mutant, unless what judges it has changed since."""
    content = _read(mutant)
    if content.get("judged_by") != judged_by():
        return None
    return _verdict(mutant, str(content["caught_by"]), bool(content["same"]))


def _hint(mutant: Mutant) -> Hint:
    content = _read(mutant)
    same = bool(content.get("same")) and content.get("answers_of") == answers_of()
    return Hint(str(content.get("caught_by", "")), same)


def _keep(mutant: Mutant, verdict: Verdict) -> None:
    content = {**asdict(verdict), "judged_by": judged_by(), "answers_of": answers_of()}
    write_whole(_path(mutant), json.dumps(content, indent=1).encode())


# ---- The command --------------------------------------------------------------------------------


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m grader.authoring.proof.mutants")
    parser.add_argument("--jobs", type=int, default=2, help="how many at once (default: 2)")
    parser.add_argument("--limit", type=int, help="that many, spread over all")
    parser.add_argument("--functions", nargs="+", default=(), help="those of some functions")
    options = parser.parse_args(arguments)
    found = run(options.jobs, options.limit, options.functions)
    for each in found.survivors:
        before, after = (" ".join(text.split()) for text in (each.before, each.after))
        print(f"{each.file}:{each.line} {each.function}: {before}  ->  {after or '(nothing)'}")
    for score in sorted(found.functions, key=lambda each: each.score):
        print(
            f"{score.score:7.1%} {score.function}: {score.caught} of {score.total},"
            f" {score.equivalent} equivalent"
        )
    print(
        f"{found.score:7.1%} in all: {found.caught} of {found.total},"
        f" {found.equivalent} equivalent, {len(found.survivors)} not caught"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
