"""Model files keep arrays and what made them, repeat to the byte, and say why they cannot be read."""

import hashlib

import numpy as np
import pytest
from formats import refused
from numpy.testing import assert_array_equal
from safetensors.numpy import save_file

from snowsim import __version__
from snowsim.io.models import fingerprint, read_model, write_model

ARRAYS = {
    "network": {"a.weight": np.arange(6, dtype=np.float32).reshape(2, 3), "a.bias": np.zeros(2, np.float32)},
    "adam": {0: {"step": np.float32(7), "exp_avg": np.ones((2, 3), np.float32)}},
}
METADATA = {"kind": "tracker", "settings": {"width": 8, "scales": (1.0, 0.5)}, "seed": 3, "step": 7}


@pytest.fixture
def path(tmp_path):
    write_model(tmp_path / "model.safetensors", ARRAYS, METADATA)
    return tmp_path / "model.safetensors"


def test_arrays_and_metadata_come_back(path):
    arrays, metadata = read_model(path)
    assert_array_equal(arrays["network"]["a.weight"], ARRAYS["network"]["a.weight"])
    assert arrays["adam"]["0"]["step"].shape == ()
    assert arrays["adam"]["0"]["step"] == 7
    assert metadata["version"] == __version__
    assert metadata["settings"] == {"width": 8, "scales": [1.0, 0.5]}


def test_the_same_model_gives_the_same_bytes(path, tmp_path):
    write_model(tmp_path / "again.safetensors", ARRAYS, dict(reversed(METADATA.items())))
    assert path.read_bytes() == (tmp_path / "again.safetensors").read_bytes()


def test_arrays_need_not_lie_in_row_order(path):
    transposed = np.arange(6.0).reshape(2, 3).T
    write_model(path, {"a": transposed}, {})
    assert_array_equal(read_model(path)[0]["a"], transposed)


def test_expected_metadata_is_compared_as_json_keeps_it(path):
    read_model(path, expected=METADATA)


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        ({"seed": 4}, "seed: expected 4, got 3"),
        ({"settings": {"width": 16, "scales": [1.0, 0.5]}}, "settings: width: expected 16, got 8"),
        ({"settings": {"width": 8}}, "settings: scales: expected None"),
        ({"kind": "cgan"}, "kind: expected 'cgan', got 'tracker'"),
        ({"data": "ab12"}, "data: expected 'ab12', got None"),
    ],
)
def test_a_model_of_another_configuration_is_refused(path, expected, words):
    refused(lambda path: read_model(path, expected=expected), path, words)


@pytest.mark.parametrize("n_bytes", [0, 5, 200, -1])
def test_a_truncated_model_is_refused_and_one_that_is_gone(path, n_bytes):
    path.write_bytes(path.read_bytes()[:n_bytes])
    refused(read_model, path, "expected a whole safetensors file")
    path.unlink()
    refused(read_model, path, "expected a whole safetensors file")


def test_a_foreign_safetensors_file_is_refused(path):
    save_file({"a": np.zeros(2)}, path)
    refused(read_model, path, "expected a model of format")


def test_a_failed_write_leaves_the_old_file(path):
    before = path.read_bytes()
    with pytest.raises(TypeError):
        write_model(path, ARRAYS, {"settings": object()})
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_the_fingerprint_depends_on_content_and_order_and_not_on_names(tmp_path):
    for name, text in (("a", "1"), ("b", "2"), ("c", "1")):
        (tmp_path / name).write_text(text)
    a, b, c = (tmp_path / name for name in "abc")
    assert fingerprint([a, b]) == fingerprint([c, b]) != fingerprint([b, a])
    digests = b"".join(hashlib.sha256(text).digest() for text in (b"1", b"2"))
    assert fingerprint([a, b]) == hashlib.sha256(digests).hexdigest()
