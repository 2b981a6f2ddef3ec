"""Training scenes for scripts, without a run of the workflow."""

from __future__ import annotations

import copy
import dataclasses
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, overload

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from snowsim.echogram import Scene, check_choice, to_uint8
from snowsim.io.files import read_dataset
from snowsim.io.pairs import SPACING, check_empty, export_pairs, warn_of_others
from snowsim.labels import draw_paper_scene, draw_scene, prepare
from snowsim.limits import check_count, check_statistics, check_values
from snowsim.phy import render_scene
from snowsim.progress import with_progress
from snowsim.seeding import generator, random_stream

REFERENCE = Path(__file__).parent / "data" / "reference_flight.nc"
# Notes of a scene: number of layer pixels below its last range bin, and of all layer pixels.
CUT = ("n_pixels_cut", "n_pixels_drawn")


@dataclass(frozen=True)
class _Recipe:
    """Settings from which each scene of `Scenes` is drawn and rendered."""

    draw: Callable  # draw(name=, rng=) returns a scene without an image
    n_range_lines: int
    n_looks: float | None  # None: that of the flight, or of the paper
    seed: int
    n_range_bins: int | None  # None: as many as the layers of each scene need
    renderer: Callable | None  # None: PHY
    options: dict  # options of `snowsim.phy.render_scene`
    spacing: dict  # range bin [s] and line spacing [m] of the flight


class Scenes(Sequence):
    """Sequence of scenes, drawn and rendered on request: image and mask (range_bin, range_line).

    Both are uint8. The mask has all layers, even those too faint to be seen. The image also has
    echoes below the deepest layer, which are not in the mask. A slice is another `Scenes`.

    Notes of a `scene` hold `bin_size_s`, `line_spacing_m`, `n_pixels_drawn`, the number of its
    layer pixels, and `n_pixels_cut`, the number of those below `n_range_bins`, which are cut off.
    `count_cut` adds up both numbers over all scenes, and `write` warns if pixels are cut off.
    """

    def __init__(self, indices, recipe):
        self._indices = indices
        self._recipe = recipe
        self._warned = False

    def __repr__(self):
        height = self._recipe.n_range_bins or "own number of"
        n_lines = self._recipe.n_range_lines
        return f"Scenes({len(self)} of {height} range bins and {n_lines} range lines)"

    def __len__(self) -> int:
        return len(self._indices)

    @overload
    def __getitem__(self, index: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]: ...
    @overload
    def __getitem__(self, index: slice) -> Scenes: ...
    def __getitem__(self, index):
        if isinstance(index, slice):
            return Scenes(self._indices[index], self._recipe)
        scene = self.scene(index)
        return scene.image, scene.mask().astype(np.uint8)

    def scene(self, index: int) -> Scene:
        """Scene of this number, a `snowsim.echogram.Scene` with image, layers and notes."""
        scene = self._render_scene(index)
        if scene.notes.get("n_pixels_cut") and not self._warned:
            self._warned = True
            msg = (
                f"n_range_bins={self._recipe.n_range_bins} cuts layers off {scene.name}, the first "
                "of such scenes: count_cut() counts them in all; None cuts nothing"
            )
            warnings.warn(msg, UserWarning, stacklevel=3)
        return scene

    def count_cut(self) -> tuple[int, int]:
        """Numbers of layer pixels, over all scenes, that `n_range_bins` cuts off, and in total."""
        notes = [self._draw_scene(index)[0].notes for index in range(len(self))]
        return tuple(sum(each.get(name, 0) for each in notes) for name in CUT)

    def _render_scene(self, index):
        """Scene of this number with its image."""
        scene, rng = self._draw_scene(index)
        if self._recipe.renderer is None:
            rendered = render_scene(scene, rng=rng, **self._recipe.options)
        else:
            rendered = rendered_by(scene, self._recipe.renderer)
        return dataclasses.replace(rendered, complete_layer_bins=scene.layer_bins)

    def _draw_scene(self, index):
        """Scene of this number without an image, of the height asked for, and its random stream."""
        recipe = self._recipe
        number = self._indices[index]
        rng = random_stream(recipe.seed, "scenes", number)
        scene = recipe.draw(name=f"drawn_{number:06d}", rng=rng)
        if recipe.n_looks is not None:
            echoes = dataclasses.replace(scene.echoes, n_looks=recipe.n_looks)
            scene = dataclasses.replace(scene, echoes=echoes)
        bins = scene.layer_bins[np.isfinite(scene.layer_bins)]
        n_cut = 0
        if recipe.n_range_bins is not None:
            n_cut = int((bins >= recipe.n_range_bins - 0.5).sum())
            scene = dataclasses.replace(scene, n_range_bins=recipe.n_range_bins)
        counts = dict(zip(CUT, (n_cut, bins.size), strict=True))
        return dataclasses.replace(scene, notes=scene.notes | recipe.spacing | counts), rng

    def write(self, folder: str | PathLike[str], *, indices=None, force: bool = False):
        """Write all scenes, or those of `indices`, to a folder as image pairs.

        Returns the counts of `snowsim.io.pairs.export_pairs`, which describes the layout. A folder
        that is not empty is refused. With `force` it is accepted: files of the same name are
        replaced, other files stay.
        """
        if not force:
            check_empty(folder)
        indices = range(len(self)) if indices is None else list(indices)
        check_count("number of scenes to write", len(indices))
        indices = with_progress(indices, unit="scene")
        counts = []

        def render_and_count():
            for index in indices:
                scene = self._render_scene(index)
                counts.append([scene.notes[name] for name in CUT])
                yield scene

        written = export_pairs(folder, render_and_count())
        warn_of_others(folder, written["n_scenes"])
        n_cut, n_drawn = np.sum(counts, axis=0)
        if n_cut:
            n_scenes = sum(n > 0 for n, _ in counts)
            msg = (
                f"n_range_bins={self._recipe.n_range_bins} cuts {n_cut} of {n_drawn} pixels of "
                f"layers off {n_scenes} of {len(counts)} scenes; None cuts nothing"
            )
            warnings.warn(msg, UserWarning, stacklevel=2)
        return written


def rendered_by(scene, renderer):
    """The scene with an image by a user's renderer: uint8 are grey levels, floats linear power.

    ValueError if the image has another type or shape, or floats that cannot be linear power.
    """
    # A copy: a renderer may use the arrays of its scene as its own, but the mask stays as drawn.
    image = np.asarray(renderer(copy.deepcopy(scene)))
    shape = (scene.n_range_bins, scene.n_range_lines)
    if image.shape != shape:
        msg = f"renderer: expected an image {shape} of scene {scene.name}, got {image.shape}"
        raise ValueError(msg)
    levels = {}
    if image.dtype != np.uint8:
        _check_power(image, scene.name)
        image, noise_floor_db, maximum_db = to_uint8(image)
        levels = {"noise_floor_db": noise_floor_db, "maximum_db": maximum_db}
    elif image.max() <= 1:
        msg = (
            f"renderer: expected grey levels from 0 to 255, of scene {scene.name}, found none "
            "above 1: of an image in [0, 1] they are (255 * image).astype(np.uint8)"
        )
        raise ValueError(msg)
    return dataclasses.replace(scene, image=image, echoes=None, **levels)


def _check_power(image, name):
    """ValueError if an image cannot be linear power.

    It has another type, values that are not above 0 or not finite, or grey levels.
    """
    found = None
    if image.dtype.kind != "f":
        found = f"type {image.dtype}"
    elif not np.isfinite(image).all() or (image <= 0).any():
        bad = image[~(np.isfinite(image) & (image > 0))]
        found = f"{bad[0]:g} on {bad.size} of {image.size} pixels"
    elif (image == np.rint(image)).all() and image.max() <= 255:
        found = f"whole numbers from {image.min():g} to {image.max():g} alone"
    if found is not None:
        msg = (
            f"renderer: expected linear power, floats above 0, or grey levels as uint8 "
            f"(image.astype(np.uint8)), of scene {name}, found {found}"
        )
        raise ValueError(msg)


def scenes(
    n: int,
    *,
    statistics: str | PathLike[str] | xr.Dataset = "reference",
    renderer: str | Callable[[Scene], NDArray[Any]] = "phy",
    rng: int | np.random.Generator,
    n_range_lines: int = 256,
    n_range_bins: int | None = None,
    recipe: str = "measured",
    n_looks: float | None = 16,
    exact: bool = False,
) -> Scenes:
    """Training scenes, as a sequence that `torch.utils.data.DataLoader` accepts.

    Parameters
    ----------
    n : int
        Number of scenes.
    statistics : "reference", path_like or xarray.Dataset, optional
        Statistics of a flight, from `snowsim.statistics`. By default those of the synthetic
        reference flight, which come with the package.
    renderer : "phy" or callable, optional
        PHY, or a function that receives a `snowsim.echogram.Scene` with its layers and echoes. It
        returns an image (range_bin, range_line), either grey levels as uint8 or linear power above
        0 as floats. Its random numbers should come from
        ``snowsim.seeding.random_stream(seed, scene.name)``.
    rng : int or numpy.random.Generator
        Seed of all scenes. Each scene has its own random stream, so scene 7 is the same in any
        order and for any `n`.
    n_range_lines, n_range_bins : int, optional
        Size of all images. By default, each image is as high as its layers require, so heights
        differ. Layers below `n_range_bins` are cut off, see `Scenes`.
    recipe : {"measured", "paper"}, optional
        "measured" draws layers as they were measured in the flight. "paper" draws them by the
        equations of Yari et al. (2021), and needs statistics of the estimator `paper`. See
        `snowsim.labels`.
    n_looks : float or None, optional
        Number of looks averaged in a pixel; None: that of the flight, or of the paper.
    exact : bool, optional
        See `snowsim.phy.render`.

    Returns
    -------
    Scenes

    Raises
    ------
    ValueError
        If a choice is unknown, if statistics lack a variable that scenes are drawn from, or if a
        renderer returns an image of another shape or type, or floats that cannot be power.

    Examples
    --------
    >>> drawn = scenes(1500, rng=1, n_range_bins=400)
    >>> image, mask = drawn[7]
    >>> len(drawn), image.shape, image.dtype, int(mask.max())
    (1500, (400, 256), dtype('uint8'), 1)
    """
    if not callable(renderer):
        check_choice("renderer", renderer, ("phy",))
    check_choice("recipe", recipe, ("measured", "paper"))
    for name, value in {"n": n, "n_range_bins": n_range_bins}.items():
        if value is not None:
            check_count(name, value)
    check_count("n_range_lines", n_range_lines, 2)
    n_range_lines = int(n_range_lines)  # numpy's small integers overflow
    if n_looks is not None:
        check_values("n_looks", n_looks, 1)
    where = "statistics"
    if not isinstance(statistics, xr.Dataset):
        where = REFERENCE if statistics == "reference" else statistics
        statistics = read_dataset(where)
    check_statistics(statistics, where)
    for name, within in SPACING.items():
        check_values(f"{where}: {name}", statistics.attrs.get(name), *within, number=True)
    if recipe == "paper" and "thickness_psd" not in statistics:
        msg = (
            f"{where}: recipe paper needs thickness_psd, which statistics of the estimator paper "
            "have: name a file of those (--statistics); fit(frames, estimator='paper') of "
            "snowsim.statistics and runs with config/as_printed.yaml make them"
        )
        raise ValueError(msg)
    options = {"exact": exact, "as_printed": recipe == "paper"}
    draw = partial(draw_paper_scene, statistics, n_range_lines)
    if recipe == "measured":
        draw = partial(draw_scene, prepare(statistics, n_range_lines), n_range_lines)
    seed = int(generator(rng).integers(2**63))
    own = renderer if callable(renderer) else None
    spacing = {name: float(statistics.attrs[name]) for name in SPACING}
    settings = _Recipe(draw, n_range_lines, n_looks, seed, n_range_bins, own, options, spacing)
    return Scenes(range(n), settings)
