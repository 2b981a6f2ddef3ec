import dataclasses

import numpy as np
import pytest
import xarray as xr
from formats import refused
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.echogram import Scene, scene_height, to_uint8
from snowsim.io.scenes import SceneSet, write_scenes


def make_scene(index, rng, n_lines=16, with_image=True):
    layer_bins = 50 + 30 * np.arange(2 + index)[:, None] + rng.standard_normal((2 + index, n_lines))
    scene = Scene(f"scene_{index}", scene_height(layer_bins), layer_bins, zone=index % 4, notes={"n": index})
    if with_image:
        image, floor, top = to_uint8(rng.gamma(5, size=(scene.n_range_bins, n_lines)))
        scene = dataclasses.replace(scene, image=image, noise_floor_db=floor, maximum_db=top)
        scene.complete_layer_bins = layer_bins.copy()
        scene.layer_bins[-1, 3] = np.nan
    return scene


def test_scenes_of_several_files_come_back_as_they_were(tmp_path, rng):
    scenes = [make_scene(i, rng) for i in range(12)]
    paths = [tmp_path / "a.nc", tmp_path / "b.nc"]
    write_scenes(paths[0], scenes[:7], {"synthetic": "yes"})
    write_scenes(paths[1], scenes[7:])
    with SceneSet(paths) as read:
        assert len(read) == 12
        assert read.attributes["synthetic"] == "yes"
        for before, after in zip(scenes, read, strict=True):
            for name in ("name", "n_range_bins", "zone", "notes", "noise_floor_db", "maximum_db"):
                assert getattr(after, name) == getattr(before, name)
            assert_array_equal(before.image, after.image)
            # float32 keeps 24 bits: 3e-5 bins at bin 500
            assert_allclose(after.layer_bins, before.layer_bins, atol=5e-5)
            assert_allclose(after.complete_layer_bins, before.complete_layer_bins, atol=5e-5)


def test_same_scenes_give_same_bytes(tmp_path, rng):
    scenes = [make_scene(i, rng) for i in range(3)]
    for name in ("a.nc", "b.nc"):
        write_scenes(tmp_path / name, scenes)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_writer_that_fails_leaves_nothing(tmp_path, rng):
    def scenes():
        yield make_scene(0, rng)
        msg = "the second scene cannot be made"
        raise RuntimeError(msg)

    with pytest.raises(RuntimeError, match="second scene"):
        write_scenes(tmp_path / "a.nc", scenes())
    assert list(tmp_path.iterdir()) == []


def test_no_scene_is_refused(tmp_path, path):
    refused(lambda path: write_scenes(path, []), path, "at least one scene")
    assert list(tmp_path.iterdir()) == []


def test_scenes_that_hold_different_things_are_refused(path, rng):
    scenes = [make_scene(0, rng), make_scene(1, rng, with_image=False)]
    refused(lambda path: write_scenes(path, scenes), path, "scene scene_1: expected .*image.* as in")


def test_a_truncated_file_is_refused_by_name(path, rng):
    write_scenes(path, [make_scene(i, rng) for i in range(3)])
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    refused(SceneSet, path, "expected a scene file")


def test_another_netcdf_file_is_refused(path):
    xr.Dataset({"x": 1.0}).to_netcdf(path)
    refused(SceneSet, path, "expected attribute format")
