"""Label sets as Yari et al. (2021), section V-B, print them, and the echoes of eqs (1)-(4)."""

import numpy as np

from snowsim.constants import BLOCK_LINES
from snowsim.echogram import SURFACE_ROW, Scene, scene_height, zone_of
from snowsim.labels.echoes import echoes_without_background, values_of
from snowsim.labels.undulations import layers_below, mirrored, notes_of
from snowsim.limits import check_count, check_statistics

FEWEST_AND_MOST_LAYERS = (5, 40)  # fewest and most below the surface
N_LOOKS = 100.0
# Bounds of every layer's Gaussian [bins^2], which section III measures as 1/e widths.
VARIANCE_BINS2 = (10.0, 15.0)


def draw_paper_scene(statistics, n_range_lines, *, name, rng):
    """One scene by the printed recipe, with all layers labelled, its zone, echoes and notes.

    The number of layers is uniform. The mean thickness of slab 0 is uniform over the flight's zones
    and fixes the zone. The mean of a deeper slab is that of slab 0 times a factor from the zone's
    Gaussian. Thickness is this mean plus a Gaussian process with the slab's spectrum,
    `thickness_psd` of the estimator `paper`, independent from slab to slab; in a scene as wide as a
    block it ends where it began. The surface is flat. `notes` are those of
    `snowsim.labels.draw_scene`. ValueError if statistics are of an earlier version, missing or not
    finite, or a scene is narrower than 2 lines.
    """
    check_count("n_range_lines", n_range_lines, 2)
    check_statistics(statistics)
    edges = values_of(statistics, "zone_edge_bins", ("edge",))
    relative_mean = values_of(statistics, "relative_thickness_mean", ("zone", "slab"))
    relative_variance = values_of(statistics, "relative_thickness_variance", ("zone", "slab"))
    psd = values_of(statistics, "thickness_psd", ("zone", "slab", "wavenumber"))
    n_layers = int(rng.integers(*FEWEST_AND_MOST_LAYERS, endpoint=True))
    first_bins = float(rng.uniform(edges[0], edges[-1]))
    zone = int(zone_of(first_bins, edges))
    slab = np.minimum(np.arange(n_layers), psd.shape[1] - 1)
    deviation = np.sqrt(relative_variance[zone, slab]) * rng.standard_normal(n_layers)
    mean = first_bins * (relative_mean[zone, slab] + deviation)
    mean[0] = first_bins
    drawn = mirrored(mean)[:, None] + _series(psd[zone, slab], n_range_lines, rng=rng)
    layer_bins = layers_below(np.full(n_range_lines, float(SURFACE_ROW)), mirrored(drawn))
    return Scene(
        name=name,
        n_range_bins=scene_height(layer_bins),
        layer_bins=layer_bins,
        complete_layer_bins=layer_bins,
        echoes=echoes_of_layers_as_printed(layer_bins, statistics, rng=rng),
        zone=zone,
        notes=notes_of(drawn, mean, first_bins),
    )


def echoes_of_layers_as_printed(layer_bins, statistics, *, rng):
    """`Echoes` of layers by the printed recipe.

    Each layer has one power, there is no background, and speckle of 100 looks is independent from
    bin to bin. The variance of each layer's Gaussian is uniform between 10 and 15 bins^2.
    ValueError if statistics are missing, not finite or not positive.
    """
    variance = rng.uniform(*VARIANCE_BINS2, len(layer_bins))
    return echoes_without_background(layer_bins, statistics, variance, n_looks=N_LOOKS)


def _series(psd, n_lines, *, rng):
    """Gaussian series (slab, range_line) with the one-sided spectra of blocks, `psd`.

    `psd` is (slab, wavenumber).
    """
    n_long = max(BLOCK_LINES, n_lines + n_lines % 2)
    held = np.fft.rfftfreq(BLOCK_LINES)
    wavenumber = np.fft.rfftfreq(n_long)
    density = np.array([np.interp(wavenumber, held, row) for row in psd])
    normal = rng.standard_normal((2, *density.shape))
    # A one-sided density 2 |X|^2 / N; at the Nyquist wavenumber |X|^2 / N, of one real normal.
    spectrum = (normal[0] + 1j * normal[1]) * np.sqrt(density * n_long) / 2
    spectrum[:, -1] = normal[0, :, -1] * np.sqrt(density[:, -1] * n_long)
    return np.fft.irfft(spectrum, n_long)[:, :n_lines]
