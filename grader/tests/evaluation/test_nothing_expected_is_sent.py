"""No expected value goes where a submission runs: all that is sent is looked through for them."""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.authoring.specimens import mistakes
from grader.checking import expected_data
from grader.checking.expected_data import Array, Batch
from grader.checks.fresnel import SKY
from grader.evaluation import plugin
from grader.execution.session_socket import SessionSocket
from grader.tests.support.judging import judge, solution

KNOWN = {each.id: each for each in mistakes.load()}
# Of a colour or a vector: fewer bytes are met by chance.
ROW = 12


class Traffic:
    """What each check has read of the expected data, and what it has sent."""

    def __init__(self) -> None:
        self.batches: defaultdict[str, list[Batch]] = defaultdict(list)
        self.sent: defaultdict[str, list[bytes]] = defaultdict(list)
        # What has come back before each of these: the submission's own answers are no secret.
        self.known: defaultdict[str, list[bytes]] = defaultdict(list)
        self._heard: defaultdict[str, bytes] = defaultdict(bytes)
        self._current = threading.local()  # checks may run side by side

    @property
    def check(self) -> str:
        """The check that runs in this thread."""
        return getattr(self._current, "check", "")

    def send(self, content: bytes) -> None:
        """Note what is sent."""
        self.sent[self.check].append(content)
        self.known[self.check].append(self._heard[self.check])

    def hear(self, content: bytes) -> None:
        """Note what has come back."""
        self._heard[self.check] += content

    def begin(self, check: str) -> None:
        """Note the check that runs in this thread from now on."""
        self._current.check = check


@pytest.fixture
def traffic(monkeypatch: pytest.MonkeyPatch) -> Traffic:
    """Return what goes to the sessions, by check."""
    found = Traffic()
    raised, read = plugin.GraderPlugin._raised, expected_data.read
    ask, put = SessionSocket.ask, SessionSocket.set

    def noting_check(self: plugin.GraderPlugin, item: pytest.Function) -> Exception | None:
        found.begin(plugin._check_id(item))
        return raised(self, item)

    def noting_batches(*words: Any) -> list[Batch]:
        batches = read(*words)
        found.batches[found.check] += batches
        return batches

    def noting_request(self: SessionSocket, head: Any, size: int, payload: bytes = b"") -> Any:
        found.send(repr(head).encode() + payload)
        answer = ask(self, head, size, payload)
        found.hear(bytes(answer))
        return answer

    def noting_variable(self: SessionSocket, name: str, payload: bytes) -> None:
        found.send(payload)
        put(self, name, payload)

    monkeypatch.setattr(plugin.GraderPlugin, "_raised", noting_check)
    monkeypatch.setattr(expected_data, "read", noting_batches)
    monkeypatch.setattr(SessionSocket, "ask", noting_request)
    monkeypatch.setattr(SessionSocket, "set", noting_variable)
    return found


def vectors(content: Array) -> Iterator[Array]:
    """Yield the tables of three floats in an array of them, or of structs that hold some."""
    if content.dtype.names:
        for name in content.dtype.names:
            yield from vectors(content[name])
    elif content.dtype == np.float32 and content.ndim > 1 and content.shape[-1] == 3:
        yield content.reshape(-1, 3)


def secrets(batch: Batch) -> set[bytes]:
    """Return what would give the answers of a batch away, as it would be sent."""
    given = b"".join(each.tobytes() for each in [*batch.args.values(), *batch.globals.values()])
    tables: list[Array] = []
    for answer in batch.answers:
        for content in (answer.result, *answer.out.values()):
            tables += vectors(content) if content is not None else []
    # A mirror's answer under the sky is its coefficient, coloured.
    tables += [table / SKY for table in tables if batch.function == "mirror_color"]
    rows = {row.astype(np.float32).tobytes() for table in tables for row in table}
    return {row for row in rows if row not in given and not _is_plain(row)}


def _is_plain(row: bytes) -> bool:
    """Whether a vector is one that anybody would send: of round numbers."""
    values = np.frombuffer(row, np.float32)
    return bool((np.mod(values * 4, 1) == 0).all() or not np.isfinite(values).all())


def found_in(traffic: Traffic) -> dict[str, int]:
    """Return how many of its secrets each check has sent."""
    counts: dict[str, int] = {}
    for check, batches in traffic.batches.items():
        rows = {row for batch in batches for row in secrets(batch)}
        pairs = list(zip(traffic.sent[check], traffic.known[check], strict=True))
        hits = [row for row in rows if any(row in sent and row not in got for sent, got in pairs)]
        counts |= {check: len(hits)} if hits else {}
    return counts


@pytest.mark.long
def test_what_is_right_is_sent_nothing_expected(traffic: Traffic, cache: Path) -> None:
    """Every check of a right program, its pictures too."""
    results = judge(solution(), cache, keyword="tp")
    assert sum(each.points for each in results.values()) == 12000
    batches = [each for own in traffic.batches.values() for each in own]
    assert sum(len(secrets(each)) for each in batches) > 10_000
    assert found_in(traffic) == {}


@pytest.mark.long
@pytest.mark.parametrize("wrong", ["shade_pi_forgotten", "mirror_black_sky", "mirror_twice"])
def test_what_is_wrong_is_sent_nothing_expected(wrong: str, traffic: Traffic, cache: Path) -> None:
    """Where a function is judged by its own answers, and beside the reference's functions."""
    results = judge(KNOWN[wrong].files(), cache, keyword="shade or mirror_color or fresnel")
    assert any(each.outcome.value == "failed" for each in results.values())
    assert "tp5.fresnel_use.mirror" in traffic.sent
    assert found_in(traffic) == {}


def test_a_value_that_is_sent_is_found(traffic: Traffic, cache: Path) -> None:
    """What the scanner is measured against: a check that sends its answers back."""
    judge(solution(), cache, keyword="fresnel_schlick.angle")
    ((check, batches),) = traffic.batches.items()
    answer = batches[0].answers[0].result
    assert answer is not None
    traffic.sent[check].append(answer.tobytes())
    traffic.known[check].append(b"")  # of which nothing has come back before
    assert found_in(traffic)[check] > 50
