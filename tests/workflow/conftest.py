"""A finished run of the tiny configuration, made once for all tests."""

import pytest
import reproducible
from runs import copy_source, made_once, run_snakemake, source_tree


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory, worker_id):
    """Folder that all workers of the session share."""
    folder = tmp_path_factory.getbasetemp()
    return folder if worker_id == "master" else folder.parent


@pytest.fixture(scope="session")
def tiny_source(shared_folder, worker_id):
    """What the tiny run is made from; workers share a copy that only tests of its reruns edit."""
    if worker_id == "master":
        return source_tree()
    return made_once(shared_folder / "source", copy_source)


@pytest.fixture(scope="session")
def tiny_run(shared_folder, tiny_source):
    """Folder of a finished run of the tiny configuration on two cores, the same for all workers."""

    def make(folder):
        run_snakemake(folder, source=tiny_source, timeout=3600)

    return made_once(shared_folder / "tiny_run", make)


@pytest.fixture(scope="session")
def reproducible_targets(tiny_run):
    """Every file of the finished run that another run must make byte for byte: no timings.

    The PNG beside a figure is no target of its own: the rule that makes the SVG writes both.
    """
    names = reproducible.digests(tiny_run / "results")
    return [f"results/{name}" for name in names if f"{name.removesuffix('.png')}.svg" not in names]
