"""A class on the instructor's desk."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.tests.batch import fake_grading
from grader.tests.batch.desk_class import Laid


@pytest.fixture
def a_class(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Laid:
    """Return an empty class; what is handed in is not compiled."""
    fake_grading.use(monkeypatch, pages=False)
    folder = tmp_path / "class"
    folder.mkdir()
    return Laid(folder, capsys)
