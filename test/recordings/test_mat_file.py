"""MAT files: what scipy writes is read as scipy reads it."""

from io import BytesIO

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from damper_estimator.recordings.mat_file import read_mat

KINDS = ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?"]


def saved(variables: dict, **options) -> bytes:
    file = BytesIO()
    scipy.io.savemat(file, variables, **options)
    return file.getvalue()


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(KINDS).flatmap(lambda kind: arrays.arrays(kind, arrays.array_shapes(max_dims=3, max_side=5))),
    st.booleans(),
    st.sampled_from(["column", "row"]),
)
def test_arrays_of_every_type_and_shape(array, compressed, lines):
    read = read_mat(saved({"x": array}, do_compression=compressed, oned_as=lines))["x"]
    assert np.array_equal(read, np.squeeze(array), equal_nan=array.dtype.kind == "f")


def test_texts_cells_and_structs():
    cell = np.array(["a", "bc", 3.0], dtype=object)
    variables = {
        "text": "gemessen",
        "rows": np.array(["ab", "cd"]),
        "cell": cell,
        "s": {"x": np.arange(3.0), "in": {"y": 5}},
    }
    read = read_mat(saved(variables))
    assert read["text"] == "gemessen" and read["rows"] == ["ab", "cd"] and read["cell"] == ["a", "bc", 3.0]
    assert read["s"]["x"].tolist() == [0.0, 1.0, 2.0] and read["s"]["in"]["y"] == 5


def test_variables_without_plain_numbers_are_dropped():
    read = read_mat(saved({"c": np.array([1 + 2j]), "sparse": scipy.sparse.eye(3).tocsc(), "x": 1.0}))
    assert list(read) == ["x"]


def test_real_files_agree_with_scipy(shared_data):
    for path in sorted((shared_data / "labcontrol_mr_damper").glob("*.mat")):
        read, expected = read_mat(path.read_bytes()), scipy.io.loadmat(path, squeeze_me=True)
        assert read.keys() == {name for name in expected if not name.startswith("__")}
        assert all(np.array_equal(value, expected[name], equal_nan=True) for name, value in read.items())


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"MATLAB 5.0", "too short"),
        (b"x" * 200, "no MAT file of version 5"),
        (b"MATLAB 7.3".ljust(124) + b"\x00\x02IM", "a MAT file of version 7.3"),
        (saved({"x": np.arange(50.0)})[:-40], "an element reaches beyond its end"),
    ],
)
def test_other_content_is_refused(content, complaint):
    with pytest.raises(ValueError, match=complaint):
        read_mat(content)
