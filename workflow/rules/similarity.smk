# Similarity of renders to the observed test scenes whose layers they have: Table II, Figs 10-12.


rule score_similarity:
    input:
        observed="results/benchmark/test/{shard}.nc",
        rendered=[f"results/{FOLDERS.get(name, name)}/test/{{shard}}.nc" for name in METHODS],
    output:
        images=expand("results/similarity/{method}/{{shard}}.csv.gz", method=METHODS),
        rows=expand("results/similarity/{method}/{{shard}}_rows.csv.gz", method=METHODS),
    log:
        "logs/score_similarity/{shard}.log",
    benchmark:
        "results/benchmarks/score_similarity/{shard}.tsv"
    params:
        methods=METHODS,
    message:
        "similarity of both renders, shard {wildcards.shard}"
    script:
        "../scripts/score_similarity.py"


rule tabulate_similarity:
    input:
        images=expand(rules.score_similarity.output.images, shard=shards("test")),
        rows=expand(rules.score_similarity.output.rows, shard=shards("test")),
    output:
        all_images="results/similarity.csv",
        table2=report("results/tables/table2.csv", category="similarity"),
        ssim_depth="results/tables/ssim_depth.csv",
    log:
        "logs/tabulate_similarity.log",
    benchmark:
        "results/benchmarks/tabulate_similarity/all.tsv"
    params:
        window_rows=config["similarity"]["window_rows"],
    message:
        "Table II"
    script:
        "../scripts/tabulate_similarity.py"


rule similarity:
    input:
        rules.tabulate_similarity.output,
    message:
        "Table II, similarity of both renders to the observed scenes"
