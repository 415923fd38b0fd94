"""Files of arrays: what is written is read back, array by array, and nothing else is taken."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest

from grader.checking.npz import Arrays, archived

ARRAYS = {
    "0.args.r": np.arange(24, dtype=np.uint8).reshape(2, 3, 4),
    "0.function": np.array("intersect_sphere"),
    "empty": np.zeros((0, 3), np.float32),
    "sky": np.full((180, 320), 0.2, np.float32),
}


def test_arrays_come_back_and_may_be_written_to() -> None:
    """Dtypes, shapes and values are the same, as numpy itself reads them too."""
    content = archived(ARRAYS)
    found = Arrays(content)
    assert [*found] == [*ARRAYS]
    with np.load(io.BytesIO(content), allow_pickle=False) as known:
        for name, value in found.items():
            assert (value.dtype, value.shape) == (known[name].dtype, known[name].shape)
            assert value.tobytes() == known[name].tobytes() == ARRAYS[name].tobytes()
    found["sky"][:] = 1
    assert found["sky"].max() == np.float32(0.2)  # each is decoded anew


def test_the_same_arrays_are_the_same_bytes() -> None:
    """Neither a date nor an address is in the file."""
    assert archived(ARRAYS) == archived({name: value.copy() for name, value in ARRAYS.items()})


@pytest.mark.parametrize(
    "value", [np.array([{}, None]), np.asfortranarray(np.zeros((2, 3)))], ids=["pickle", "fortran"]
)
def test_only_plain_arrays_are_taken(value: np.ndarray) -> None:  # type: ignore[type-arg]
    """Nothing is unpickled, and no other layout is taken for ours."""
    member = io.BytesIO()
    np.save(member, value, allow_pickle=True)
    with pytest.raises(ValueError, match="not a plain array"):
        Arrays(_zipped(member.getvalue()))["x"]


@pytest.mark.parametrize("member", [b"", b"not an array at all", archived({})])
def test_what_is_no_array_is_refused(member: bytes) -> None:
    """Whatever stands in the archive instead."""
    with pytest.raises(ValueError, match=r"magic|not an array of ours"):
        Arrays(_zipped(member))["x"]


def test_what_is_no_archive_is_refused() -> None:
    """At once, before any array is asked for."""
    with pytest.raises(ValueError, match="not a zip file"):
        Arrays(b"PK and nothing else")


def _zipped(member: bytes) -> bytes:
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", member)
    return memory.getvalue()
