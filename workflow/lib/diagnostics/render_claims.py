"""Claims on renders: where layers lie, texture, contrast, similarity."""

import numpy as np

from lib.diagnostics.verdicts import BY_INTERVAL, Verdict, paired_verdict

METHODS = {"phy": "PHY", "cgan": "cGAN", "observed": "the observed scene itself"}


def _by_method(table, value):
    """A column of a table by scene, one column per method, NaN where it was not measured; a row a scene and method."""
    return table.pivot(index="scene", columns="method", values=value).reindex(columns=list(METHODS))


def curvature(positions):
    """PHY follows the curvature of layers better: position errors where layers bend most."""
    bent = positions[(positions["against"] == "curvature") & (positions["shape_class"] == 3)]
    error = _by_method(bent, "mean_abs_error_bins")
    verdict, text = paired_verdict(error["cgan"] - error["phy"], "range bins")
    means = ", ".join(f"{name} {error[key].mean():.2f}" for key, name in METHODS.items())
    return Verdict(
        "PHY follows the curvature of layers better than the cGAN.",
        verdict,
        f"Mean distance from a layer to the brightest pixel near it, in the quarter of pixels where layers bend most: "
        f"{means} range bins. cGAN less PHY {text}.",
        BY_INTERVAL,
        "The brightest pixel near a layer moves with speckle too, in the observed scene as in renders.",
    )


def texture(textures):
    """CGAN has the better texture: its spectrum below the surface is nearer to the observed."""
    distance = _by_method(textures[textures["region"] == "below"], "spectrum_distance_db")
    verdict, text = paired_verdict(distance["phy"] - distance["cgan"], "dB")
    return Verdict(
        "The cGAN has the better texture.",
        verdict,
        f"Distance of the radial spectrum from the observed one, below the surface: cGAN {distance['cgan'].mean():.2f} "
        f"dB, PHY {distance['phy'].mean():.2f} dB. PHY less cGAN {text}.",
        BY_INTERVAL,
    )


def contrast(textures):
    """CGAN has the better contrast: deviation of grey levels below the surface nearer to the observed."""
    deviation = _by_method(textures[textures["region"] == "below"], "deviation")
    off = {name: (deviation[name] - deviation["observed"]).abs() for name in ("cgan", "phy")}
    verdict, text = paired_verdict(off["phy"] - off["cgan"], "grey levels")
    return Verdict(
        "The cGAN has the better contrast.",
        verdict,
        f"Standard deviation of grey levels below the surface: observed {deviation['observed'].mean():.1f}, cGAN "
        f"{deviation['cgan'].mean():.1f}, PHY {deviation['phy'].mean():.1f}. Distance from the observed, "
        f"PHY less cGAN {text}.",
        BY_INTERVAL,
    )


def similarity_claim(images, metric, sign, sentence, unit):
    """One similarity metric is better for the cGAN; `sign` is +1 where more is better."""
    values = _by_method(images, metric)
    values = values.where(np.isfinite(values))
    verdict, text = paired_verdict(sign * (values["cgan"] - values["phy"]), unit)
    first, second = ("cGAN", "PHY") if sign > 0 else ("PHY", "cGAN")
    means = f"cGAN {values['cgan'].mean():.2f}, PHY {values['phy'].mean():.2f}"
    return Verdict(sentence, verdict, f"Mean over scenes: {means}. {first} less {second} {text}.", BY_INTERVAL)


def region_claim(textures, region, better, sentence):
    """SSIM in one region is higher for the method `better`."""
    ssim = _by_method(textures[textures["region"] == region], "ssim")
    other = "phy" if better == "cgan" else "cgan"
    verdict, text = paired_verdict(ssim[better] - ssim[other])
    names = {"cgan": "cGAN", "phy": "PHY"}
    return Verdict(
        sentence,
        verdict,
        f"Mean SSIM {region} the surface: cGAN {ssim['cgan'].mean():.3f}, PHY {ssim['phy'].mean():.3f}. "
        f"{names[better]} less {names[other]} {text}.",
        BY_INTERVAL,
    )


def needless_texture(textures):
    """CGAN adds texture above the surface: its neighbouring range lines resemble each other more than observed ones."""
    above = textures[textures["region"] == "above"]
    likeness, deviation = _by_method(above, "autocorrelation_line"), _by_method(above, "deviation")
    verdict, text = paired_verdict(likeness["cgan"] - likeness["observed"])
    parts = ", ".join(
        f"{name} {likeness[key].mean():.3f} ({deviation[key].mean():.1f} grey levels of deviation)"
        for key, name in (("observed", "observed"), ("cgan", "cGAN"), ("phy", "PHY"))
    )
    return Verdict(
        "The cGAN adds texture above the surface.",
        verdict,
        f"Autocorrelation of neighbouring range lines above the surface, zero for noise: {parts}. cGAN less observed "
        f"{text}.",
        BY_INTERVAL,
    )
