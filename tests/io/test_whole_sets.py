"""Files of one command replace those of an earlier one together, or none of them does."""

import errno
import platform
from contextlib import suppress
from pathlib import Path

import formats
import numpy as np
import pytest
from planted_layers import CARD, SEGMENT, content_of, planted, ridge_weights, write_weights

from snowsim.cli import main
from snowsim.io import read_tracker
from snowsim.io.files import written_together, written_whole
from snowsim.io.models import write_tracker

# Commands that write several files; {n} makes each run's files differ from the last one's.
COMMANDS = [
    "simulate Data_20150512_03_001.mat --frames 2 --range-lines 30 --years 3 --seed {n} --force",
    "simulate other.nc --range-lines 30 --years 3 --seed {n} --force",
    "scenes drawn -n 2 --range-lines 30 --range-bins 300 --seed {n} --force",
    "accumulation known_layers.nc -o a.csv --density 35{n} --annual --force",
    "accumulation known_layers.nc -o b.nc --density 35{n} --annual --png --force",
    "track seen_{n}/{first} seen_{n}/{second} -o picked --model ridges.onnx --force",
]
FRAMES = {name: f"Data_{SEGMENT}_00{n}.mat" for n, name in enumerate(("first", "second"), 1)}
FAILURES = (OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt())


@pytest.fixture
def fail(monkeypatch):
    """Function that lets the writing of a further file fail, by its number from 1 on."""
    own = platform.node

    def at(number, error):
        left = [number]

        def begins_to_write():
            left[0] -= 1
            if left[0] == 0:
                raise error
            return own()

        # Each file begins with a name for its temporary file.
        monkeypatch.setattr("snowsim.io.files.platform.node", begins_to_write)
        return left

    return at


def contents(folder):
    """Content of every file below a folder by its path."""
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Folder with what the commands read."""
    monkeypatch.chdir(tmp_path)
    write_weights(tmp_path, ridge_weights())
    for n in (1, 2):
        folder = Path(f"seen_{n}")
        folder.mkdir()
        echogram, _ = planted(np.random.default_rng(n), n_lines=200)
        for number in (1, 2):
            lines = slice(100 * number - 100, 100 * number)
            path = folder / f"Data_{SEGMENT}_00{number}.mat"
            formats.write_mat5(path, content_of(echogram, lines))
    return tmp_path


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_that_fails_at_any_of_its_files_leaves_all_that_were_there(
    place, fail, command, capsys
):
    if command.startswith("accumulation"):
        main(["simulate", "known.nc", "--range-lines", "30"])
    main(command.format(n=1, **FRAMES).split())
    before = contents(place)
    n_files = 0
    for number in range(1, 20):
        left = fail(number, FAILURES[number % 2])
        with suppress(SystemExit):
            main(command.format(n=2, **FRAMES).split())
        if left[0] > 0:
            break
        n_files = number
        assert contents(place) == before, number
        capsys.readouterr()
    assert n_files >= 2
    after = contents(place)
    assert after.keys() == before.keys()
    assert sum(after[path] != before[path] for path in before) >= 2


def test_a_network_and_its_card_are_replaced_together(tmp_path, fail):
    path = tmp_path / "a.onnx"
    write_tracker(path, b"first", CARD)
    fail(2, FAILURES[0])
    with pytest.raises(OSError, match="No space left"):
        write_tracker(path, b"second", CARD)
    assert read_tracker(path)[0] == b"first"
    assert len(list(tmp_path.iterdir())) == 2


def test_a_set_within_another_is_whole_by_itself_and_a_file_written_twice_is_the_later(tmp_path):
    def write(name, text):
        with written_whole(tmp_path / name) as aside:
            aside.write_text(text)

    def fail_after():
        with written_together():
            write("outer", "new")
            with written_together():
                write("inner", "first")
                write("inner", "second")
            assert not (tmp_path / "outer").exists()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail_after()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"inner": "second"}
