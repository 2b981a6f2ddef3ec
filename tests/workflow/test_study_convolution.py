"""The study of SMRT says in one line what is missing."""

import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "workflow/scripts"


def test_a_missing_smrt_is_named_with_how_to_get_it(monkeypatch):
    monkeypatch.syspath_prepend(SCRIPTS)
    monkeypatch.setitem(sys.modules, "smrt", None)  # importing it then fails
    from lib.diagnostics.smrt_waveforms import import_smrt

    with pytest.raises(ValueError, match=r"smrt, which is not installed: pip install 'snowsim\[studies\]'"):
        import_smrt()
