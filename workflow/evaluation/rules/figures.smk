# One job draws all figures of a stage, as workflow/figures.yaml lists them.

from lib import registry

# What the names in braces stand for in paths of the list.
N_SHOWN = FIGURES["renders"]["synthetic.svg"]["settings"]["n_labels"]
SHOWN = first_shards(N_SHOWN)
FILES_OF = {
    "frame": flight_files,
    "middle": lambda path: middle_frame(path.replace("{middle}", "{frame}")),
    "train": lambda path: expand(path, train=shards("train")),
    "test": lambda path: expand(path, test=shards("test")),
    "first": lambda path: expand(path, first=SHOWN),
    "training_set": lambda path: expand(path, training_set=TRAINING_SETS),
}
# Snakemake's own report takes captions from files alone.
CAPTIONS = Path(".snakemake/captions").absolute()
if workflow.is_main_process:
    registry.write_captions(FIGURES, CAPTIONS)

for (plot, stage), figures in registry.plots(FIGURES, LEFT_OUT).items():

    rule:
        name:
            plot
        input:
            **registry.inputs_of(figures, FILES_OF),
            code=registry.drawn_by(stage),
        output:
            figures=[
                report(
                    f"results/figures/{file}",
                    caption=str(CAPTIONS / f"{file}.rst"),
                    category=stage,
                )
                for file in figures
            ],
            tables=expand(
                "results/tables/{table}", table=registry.named_by(figures, "makes")
            ),
        log:
            f"logs/{plot}.log",
        benchmark:
            f"results/benchmarks/{plot}/all.tsv"
        params:
            stage=stage,
            source=NOTE,
            settings=registry.settings_of(figures),
            scenes=registry.named_by(figures, "scenes"),
            studies=finished(
                f"results/{study}" for study in registry.named_by(figures, "studies")
            ),
        message:
            f"figures of the stage {stage}"
        script:
            "../scripts/plot.py"


rule charts:
    input:
        rules.plot_flight.output,
    message:
        "figures of the flight and of its statistics"
