"""Range lines that quality flags take out: their power and picks become NaN, all flags are counted."""

import numpy as np
import xarray as xr

# Flags of an IRSNO1B supplement, set by hand for whole frames, with what the archive says of each. Not here by
# default: `deconvolution_artifact`, sidelobes in the deconvolved product, some 30 dB below a bright echo: layers stay
# where they are, and the same supplement lies beside the plain product; `low_SNR`, weak, but measured: without such
# lines the mean power would come out too high; `land_ice`, what is on the ground, no defect.
FLAGGED_BY = (
    "coh_noise_removal_artifact",  # power that is no echo, in the air that gives the noise and under the picks
    "vertical_stripes_artifact",  # the same: vertical stripes or raised noise floor
    "missing_data",  # the range gate clips the echogram
    "no_good_data",  # not to be trusted
    "unclassified_artifact",  # not to be trusted
)


def leave_out_flagged(echogram, layers, *, flags=FLAGGED_BY):
    """Echogram, with `flagged (slow_time)`, and layers without the power and picks of lines that have one of `flags`.

    Both become NaN, as where nothing was recorded, and nothing is put in their place; the lines stay, so that their
    neighbours keep their distance. The echogram's `quality_mask (slow_time)` holds one bit a flag, named by its
    attributes `flag_masks` and `flag_meanings` (CF conventions, section 3.5); it need not know them all. Without a
    mask, echogram and layers come back as they are.
    """
    held = flagged_lines(echogram)
    if held is None:
        return echogram, layers
    flagged = np.zeros(echogram.sizes["slow_time"], dtype=bool)
    for name in flags:
        flagged |= held.get(name, False)
    echogram = echogram.assign(flagged=("slow_time", flagged))
    if flagged.any():
        fit = xr.DataArray(~flagged, dims="slow_time")
        echogram["Data"] = echogram["Data"].where(fit)
        layers = layers.assign(twtt=layers["twtt"].where(fit))
    return echogram, layers


def flagged_lines(echogram):
    """Which range lines have each flag, {name: bool (range_line,)}; None for an echogram without a mask of flags."""
    mask = echogram.get("quality_mask")
    if mask is None or mask.dtype.kind not in "iu" or not {"flag_masks", "flag_meanings"} <= set(mask.attrs):
        return None
    names, bits = str(mask.attrs["flag_meanings"]).split(), np.atleast_1d(mask.attrs["flag_masks"])
    return {name: (mask.values & bit) != 0 for name, bit in zip(names, bits, strict=True)}


def count_flagged(echogram):
    """How many range lines `leave_out_flagged` left out, and all flags in words, such as "low_SNR 12; land_ice 512".

    Words are "none" where there is a mask without a flag, and empty where there is no mask.
    """
    held = flagged_lines(echogram)
    n_flagged = int(echogram["flagged"].sum()) if "flagged" in echogram else 0
    if held is None:
        return n_flagged, ""
    counts = {name: int(lines.sum()) for name, lines in held.items()}
    return n_flagged, "; ".join(f"{name} {n}" for name, n in counts.items() if n) or "none"
