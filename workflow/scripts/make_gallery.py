"""Test scenes for the report's gallery: images compressed, layers as lines, similarity of both renders."""

from job import job

from lib.report.gallery import choose_scenes, layer_lines
from lib.report.page import image_uri, write_json
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet

METRICS = ("ssim", "psnr", "rmse")


def gallery(paths, path_to_images, path_to_statistics, path_to_gallery, n_scenes, source):
    scores = read_table(path_to_images).set_index(["scene", "method"])
    with SceneSet(paths["observed"]) as observed:
        chosen = choose_scenes([scene.layer_bins.shape[0] for scene in observed], n_scenes)
        scenes = [describe(observed[i], scores) for i in chosen]
    for method, files in paths.items():
        with SceneSet(files) as rendered:
            for scene, i in zip(scenes, chosen, strict=True):
                scene["images"][method] = image_uri(rendered[i].image)
    bin_size_s = float(read_dataset(path_to_statistics).attrs["bin_size_s"])
    write_json(path_to_gallery, {"source": source, "bin_size_s": bin_size_s, "scenes": scenes})


def describe(scene, scores):
    """Everything of a scene but its images."""
    return {
        "name": scene.name,
        "n_range_bins": scene.n_range_bins,
        "n_range_lines": scene.n_range_lines,
        "n_layers": scene.layer_bins.shape[0] - 1,
        "layers": layer_lines(scene.layer_bins),
        "images": {},
        "scores": {
            method: {metric: round(float(scores.loc[(scene.name, method), metric]), 3) for metric in METRICS}
            for method in ("cgan", "phy")
        },
    }


if __name__ == "__main__":
    with job(snakemake):
        gallery(
            {name: list(snakemake.input[name]) for name in ("observed", "cgan", "phy")},
            snakemake.input.images,
            snakemake.input.statistics,
            *snakemake.output,
            **snakemake.params,
        )
