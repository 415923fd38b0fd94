"""The page of each person: the report of their submission under their own name, and their delay.

results.json stays as it was graded: names and lateness come from elsewhere, and change without it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from grader.batch.dependencies import WORDING
from grader.batch.moodle_files import folder_name
from grader.batch.names import is_folder_of
from grader.batch.records import Candidate, Graded, Mark
from grader.batch.results_folder import ResultsFolder
from grader.course.texts import Texts
from grader.files import content_key, write_whole
from grader.report import page


class Pages:
    """Makes the pages of a class; those that have not changed since the last run are read back."""

    def __init__(
        self,
        results: ResultsFolder,
        marks: Sequence[Mark],
        graded: Mapping[str, Graded],
        before: Mapping[str, str],
        texts: Texts,
    ) -> None:
        self._results, self._graded, self._before, self._texts = results, graded, before, texts
        self.made: dict[str, str] = {}  # what each page comes of, for the next run
        self._members: dict[str, list[Mark]] = {}
        for each in marks:
            if not each.member.unsettled and self._is_graded(each.member.submission):
                self._members.setdefault(each.member.submission, []).append(each)

    def _is_graded(self, name: str) -> bool:
        known = self._graded.get(name)
        return bool(known and known.results)

    def write(self) -> None:
        """Write the page of each submission, of all its authors. Raises OSError."""
        for name, marks in self._members.items():
            folder = self._results.folder(name)
            key = self._key(folder, marks)
            self.made[name] = key
            if self._before.get(name) != key:
                write_whole(folder / page.NAME, self._page(folder, marks))

    def feedback(self) -> dict[str, bytes]:
        """Return the pages for Moodle, by the name of the folder of a person or of a group.

        Of a group there is one; of a pair each has their own, since each has their own delay.
        """
        found = {}
        for name, marks in self._members.items():
            folder, candidate = self._results.folder(name), self._graded[name].candidate
            whole = (folder / page.NAME).read_bytes()
            same = len({repr(each.late) for each in marks}) == 1
            for label, number, own in _receivers(candidate, marks):
                content = whole if same or len(own) > 1 else self._page(folder, marks, own)
                found[folder_name(label, number)] = content
        return found

    def _page(self, folder: Path, marks: Sequence[Mark], own: Sequence[Mark] = ()) -> bytes:
        """Return a page under the names of all the authors, with the delay of some."""
        content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        shown = own or marks
        content["submission"]["name"] = _names(marks)
        content["notes"] = [*self._late(shown), *content["notes"]]
        return page.render(content, folder).encode("utf-8", errors="replace")

    def _late(self, marks: Sequence[Mark]) -> Iterator[str]:
        """Yield what lateness has taken off; whose it is when it is not everybody's."""
        told = [each.late and self._texts.say(each.late.key, **each.late.values) for each in marks]
        if len(set(told)) == 1:
            yield from (each for each in told[:1] if each)
            return
        for each, text in zip(marks, told, strict=True):
            if text:
                yield f"{each.member.name} : {text}"

    def _key(self, folder: Path, marks: Sequence[Mark]) -> str:
        content = (folder / "results.json").read_bytes()
        about = (_names(marks), list(self._late(marks)))
        wording = self._graded[marks[0].member.submission].parts.get(WORDING)
        return content_key(content, about, wording)


def _names(marks: Sequence[Mark]) -> str:
    return ", ".join(dict.fromkeys(each.member.name for each in marks))


def _receivers(
    candidate: Candidate, marks: Sequence[Mark]
) -> Iterator[tuple[str, str, Sequence[Mark]]]:
    """Yield who gets a page in Moodle: label and number of their folder, and whose marks."""
    groups = {each.member.enrolled.group for each in marks if each.member.enrolled}
    if candidate.moodle and any(is_folder_of(candidate.label, each) for each in groups):
        if candidate.number:  # Moodle's default group has none, and gets no file by an archive
            yield candidate.label, candidate.number, marks
        return
    for each in marks:
        if each.member.moodle:
            yield each.member.name, each.member.moodle, [each]
