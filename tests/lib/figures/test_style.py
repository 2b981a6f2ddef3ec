"""Figures on disk."""

import pytest

from lib.figures.style import new_figure, write_figure


@pytest.mark.parametrize("ending", [".svg", ".png"])
def test_the_same_figure_gives_the_same_bytes(tmp_path, ending):
    paths = [tmp_path / f"{name}{ending}" for name in "xy"]
    for path in paths:
        figure, axes = new_figure()
        axes[0, 0].plot([1, 2], label="line")
        axes[0, 0].legend()
        write_figure(path, figure)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_figure_of_another_kind_is_refused(tmp_path):
    figure, _ = new_figure()
    with pytest.raises(ValueError, match=r"ends in \.svg or \.png"):
        write_figure(tmp_path / "a.jpg", figure)
