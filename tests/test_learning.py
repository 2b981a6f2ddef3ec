"""A tracker trained on a user's own scenes: what it starts from, holds out and writes."""

import dataclasses

import pytest
from refusals import refusal
from toy_scenes import toy_scenes, with_ridges

from snowsim.io import PairSet, export_pairs, read_tracker
from snowsim.learning import held_out_score, network_of_tracker, train_tracker
from snowsim.tracker import checked_card


def train(path, scenes, **changes):
    """The card of a tracker trained on scenes for a step."""
    options = {"n_steps": 1, "seed": 1, "bin_s": 2e-10, "line_spacing_m": 4.0}
    return train_tracker(path, [scenes], **options | changes)


def test_training_writes_a_network_and_the_card_that_fits_it(tmp_path):
    card = train(tmp_path / "mine.onnx", toy_scenes(11), n_steps=3)
    content, read = read_tracker(tmp_path / "mine.onnx")
    assert read["name"] == "mine"
    assert (read["bin_s"], read["line_spacing_m"]) == (2e-10, 4.0)
    assert "9 scenes" in read["trained_on"]  # of 11 every tenth, from the first on, is held out
    assert read["temperature"] == card["temperature"] > 0
    assert card["held_out"] == {"n_scenes": 2}
    assert checked_card(read, "mine").outside({})  # without ranges nothing lies within
    again = tmp_path / "again.onnx"
    train(again, toy_scenes(11), n_steps=3)
    assert again.read_bytes() == content


def test_training_from_the_shipped_tracker_starts_at_its_weights(tmp_path):
    path = tmp_path / "mine.onnx"
    train(path, toy_scenes(3), start="universal")
    network, card = network_of_tracker("universal")
    shipped = network.state_dict()
    network, own = network_of_tracker(path)
    # How sure its picks are was not measured: none is rated good.
    assert checked_card(own, "mine").outside({})
    found = network.state_dict()
    for name, values in shipped.items():
        if name == "fuse.bias":  # takes in the offset of the calibration
            continue
        # One step of a thousandth at most, Adam's, and decay of a hundredth of that.
        assert (found[name] - values).abs().max() < 1.1e-3, name
    assert any((found[name] - values).abs().max() > 0 for name, values in shipped.items())


def test_the_score_of_scenes_held_out_lies_in_its_interval_and_needs_ten():
    scenes = list(map(with_ridges, toy_scenes(10)))
    # Half of the maps lack what the others show.
    maps = [scene.image / 255 * (1 if place % 2 else 0) for place, scene in enumerate(scenes)]
    told = held_out_score(maps, scenes)
    assert told["n_scenes"] == 10
    assert 0 < told["low"] < told["ods"] < told["high"] < 1
    assert held_out_score(maps[1:], scenes[1:]) == {"n_scenes": 9}


def test_the_name_of_what_is_no_tracker_is_refused(tmp_path):
    message = r"other.onnx: expected a tracker that comes with the package \(universal\) or"
    with refusal(message):
        network_of_tracker(str(tmp_path / "other.onnx"))


def test_one_scene_leaves_none_to_calibrate_on(tmp_path):
    with refusal("one for the calibration, must .* at least 2, got 1"):
        train(tmp_path / "mine.onnx", toy_scenes(1))
    with refusal("line_spacing_m must be finite"):
        train(tmp_path / "mine.onnx", toy_scenes(2), line_spacing_m=float("inf"))


def test_range_bins_are_those_in_the_scenes_notes_and_all_the_same(tmp_path):
    scenes = toy_scenes(3)
    for scene in scenes:
        scene.notes["bin_size_s"] = 3e-10
    card = train(tmp_path / "mine.onnx", scenes, bin_s=None)
    assert card["bin_s"] == 3e-10
    with refusal("expected range bins of 2e-10 s, .* found 3e-10 s"):
        train(tmp_path / "other.onnx", scenes)


def test_both_spacings_are_those_beside_the_pairs(tmp_path):
    scenes = [dataclasses.replace(scene, name=f"toy_{i}") for i, scene in enumerate(toy_scenes(3))]
    for scene in scenes:
        scene.notes.update(bin_size_s=1.5e-10, line_spacing_m=9.0)
    export_pairs(tmp_path / "pairs", scenes)
    pairs = PairSet(tmp_path / "pairs")
    card = train(tmp_path / "mine.onnx", pairs, bin_s=None, line_spacing_m=None)
    assert (card["bin_s"], card["line_spacing_m"]) == (1.5e-10, 9.0)
    with refusal("expected range lines of 8 m, .* found 9 m"):
        train(tmp_path / "other.onnx", pairs, bin_s=None, line_spacing_m=8.0)
    with pytest.warns(UserWarning, match="^scenes do not state the spacing of") as warned:
        train(tmp_path / "third.onnx", toy_scenes(3), bin_s=None, line_spacing_m=None)
    said = [str(each.message) for each in warned]
    assert [each for each in said if not each.startswith("bfloat16")] == [  # without AVX-512
        "scenes do not state the spacing of their range bins: 2.886e-10 s assumed",
        "scenes do not state the spacing of their range lines: 5.2 m assumed",
    ]


def test_scenes_that_do_not_state_their_spacing_are_counted(tmp_path):
    scenes = toy_scenes(3)
    scenes[1].notes["bin_size_s"] = 3e-10
    with pytest.warns(UserWarning, match=r"2 of 3 scenes do not state .* bins: 3e-10 s, that of"):
        assert train(tmp_path / "mine.onnx", scenes, bin_s=None)["bin_s"] == 3e-10


def test_copies_of_scenes_are_refused_since_one_would_be_held_out(tmp_path):
    first, again = toy_scenes(11), toy_scenes(11)[3:4]
    with refusal(f"found 1 copies: {again[0].name} of set 2 is {first[3].name} of set 1"):
        train_tracker(
            tmp_path / "mine.onnx", [first, again], n_steps=1, seed=1, bin_s=None, line_spacing_m=4
        )


def test_a_gpu_that_is_not_there_is_refused_before_anything_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    with refusal("^device cuda: expected a GPU"):
        train(tmp_path / "mine.onnx", toy_scenes(3), device="cuda")
    assert not list(tmp_path.iterdir())
