"""One set of scenes as image pairs for other people's code, with a list for each part."""

from pathlib import Path

from job import job, progress

from snowsim.io.files import written_whole
from snowsim.io.pairs import export_pairs
from snowsim.io.scenes import SceneSet

with job(snakemake):
    folder = snakemake.output.folder
    lines = [snakemake.params.what]
    for name, paths in snakemake.params.lists.items():
        list_name = f"{name}.lst"
        with SceneSet(paths) as scenes:
            shown = progress(scenes, f"export of {name}")
            layers = snakemake.params.layers
            counts = export_pairs(folder, shown, list_name=list_name, layers=layers)
        text = ", ".join(f"{key} {count}" for key, count in counts.items())
        lines.append(f"{list_name}: {text}")
    about = "".join(f"{line}\n" for line in lines)
    with written_whole(Path(folder) / "about.txt") as aside:
        aside.write_text(about, encoding="utf-8")
