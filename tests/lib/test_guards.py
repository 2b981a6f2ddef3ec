"""What is checked before the first job of a run, without a run."""

import pytest

from lib.guards import check_disk, check_folders


def test_a_run_that_the_disk_has_no_room_for_is_refused(tmp_path):
    check_disk(1, tmp_path / "results")
    with pytest.raises(ValueError, match=rf"^disk: this run writes about 10{{12}} MB, {tmp_path} has \d+ MB left$"):
        check_disk(1e18, tmp_path / "results")


def test_a_folder_is_judged_by_the_first_that_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check_folders("results/a/b", "logs")
    monkeypatch.setattr("os.access", lambda folder, mode: folder != tmp_path)
    with pytest.raises(ValueError, match=rf"^disk: logs/ cannot be written: {tmp_path} is read-only$"):
        check_folders("logs")
