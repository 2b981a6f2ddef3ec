"""What the trainings of the tracker's study are, from its settings."""

import pandas as pd
import pytest

from lib.tracker_runs import ablation_of, best_runs, check_names, data_of, training_of

TRACKER = {
    "added_per_real": 0.6,
    "order": "mixed",
    "added_layers": None,
    "training": {"n_steps": 100, "learning_rate": 1e-3},
}
STUDY = {
    "ablation": [
        {"name": "masked", "training_sets": ["rd"], "training": {"mask_unannotated": True}},
        {"name": "longer", "training_sets": ["rd"], "steps": 2},
    ],
    "networks": [{"name": "width_4"}],
}


def test_a_setting_changes_what_it_names_and_nothing_else():
    masked, longer = STUDY["ablation"]
    assert training_of(masked, TRACKER) == {"n_steps": 100, "learning_rate": 1e-3, "mask_unannotated": True}
    assert training_of(longer, TRACKER) == {"n_steps": 200, "learning_rate": 1e-3}
    assert data_of(longer, TRACKER) == {"added_per_real": 0.6, "order": "mixed", "n_layers": None}
    assert data_of({"n_layers": 3, "zones": [0]}, TRACKER)["n_layers"] == 3


def test_the_best_of_the_candidates_is_chosen_beside_the_defaults(tmp_path):
    rows = [("default", "rd", 0.5), ("masked", "rd", 0.6), ("longer", "rd", 0.9), ("default", "rd_pd", 0.7)]
    table = pd.DataFrame(rows, columns=["setting", "training_set", "mean"]).assign(metric="ods")
    table.to_csv(tmp_path / "ablation.csv", index=False)
    # More steps are another experiment, however well they do.
    runs = best_runs(tmp_path / "ablation.csv", ablation_of(STUDY, ["rd", "rd_pd"]))
    assert runs == [("default", "rd"), ("default", "rd_pd"), ("masked", "rd")]


def test_a_name_given_twice_is_refused():
    twice = {**STUDY, "networks": [{"name": "masked"}]}
    with pytest.raises(ValueError, match="expected every name once, got masked 2 times"):
        check_names(twice)
