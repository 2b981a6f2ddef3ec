# Figures of the flight and of its statistics.


rule plot_flight:
    input:
        echograms=flight_files("results/flight/{frame}.nc"),
        layers=flight_files("results/flight/{frame}_layers.nc"),
        code=imported_by("plot_flight.py"),
    output:
        table="results/tables/flight.csv",
        echogram=report(
            "results/figures/echogram.svg", caption="../report/echogram.rst"
        ),
        positions=report(
            "results/figures/flight_line.svg", caption="../report/flight_line.rst"
        ),
    log:
        "logs/plot_flight.log",
    benchmark:
        "results/benchmarks/plot_flight/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of the flight"
    script:
        "../scripts/plot_flight.py"


rule plot_statistics:
    input:
        statistics="results/statistics.nc",
        code=imported_by("plot_statistics.py"),
    output:
        waveforms=report(
            "results/figures/waveforms.svg", caption="../report/waveforms.rst"
        ),
        spectra=report(
            "results/figures/along_track.svg", caption="../report/along_track.rst"
        ),
    log:
        "logs/plot_statistics.log",
    benchmark:
        "results/benchmarks/plot_statistics/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of the flight statistics"
    script:
        "../scripts/plot_statistics.py"


rule charts:
    input:
        *(
            []
            if "map and echogram of the flight" in LEFT_OUT[SOURCE]
            else rules.plot_flight.output
        ),
        rules.plot_statistics.output,
    message:
        "figures of the flight and of its statistics"
