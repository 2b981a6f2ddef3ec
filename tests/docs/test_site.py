"""The pages build, fetch nothing, and have every public function."""

import re
import sys

import pytest
from processes import ROOT, run_in

PUBLIC = (
    "snowsim.score_folders",
    "snowsim.agreement",
    "snowsim.simulate",
    "snowsim.scenes",
    "snowsim.statistics.fit",
    "snowsim.statistics.varied",
    "snowsim.labels.draw",
    "snowsim.phy.mean_power",
    "snowsim.phy.render",
    "snowsim.phy.draw_speckle",
    "snowsim.metrics.image.similarity",
    "snowsim.metrics.edges.match_counts",
    "snowsim.metrics.edges.score",
    "snowsim.metrics.edges.suppress",
    "snowsim.io.read_echogram",
    "snowsim.io.read_layers",
    "snowsim.io.echogram",
)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the documentation, built with every warning an error."""
    folder = tmp_path_factory.mktemp("site")
    options = ["-b", "html", "-W", "--keep-going", "-n", "-q", "-d", folder / "doctrees"]
    run_in(folder, sys.executable, "-m", "sphinx", *options, ROOT / "docs", folder / "html")
    return folder / "html"


# What a page would fetch from elsewhere, and pictures without a text. Thumbnails of the gallery
# stand beside their title, and have none on purpose.
FETCHED = r"<(?!a\s)[^>]*\s(?:src|href)=\"(?:https?:)?//[^>]*>"
WITHOUT_TEXT = r"<img(?![^>]*\salt=\"[^\"])(?![^>]*_thumb\.png)[^>]*>"


@pytest.mark.slow
def test_pages_fetch_nothing_and_describe_their_pictures(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 15
    for page in pages:
        assert not re.findall(f"{FETCHED}|{WITHOUT_TEXT}", page.read_text()), page
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//", style.read_text()), style


@pytest.mark.slow
def test_pages_have_equations_the_settings_and_every_public_function(site):
    assert "<math" in (site / "stages/phy.html").read_text()
    settings = (site / "configuration.html").read_text()
    assert "fold_length_lines" in settings  # a user turns it
    assert "horizon_jump_kg_m3" in settings  # a dataclass has it
    api = (site / "api.html").read_text()
    for name in PUBLIC:
        assert f'id="{name}"' in api, name
