# Waveforms of the nadir altimetry solver of SMRT beside eq. (1) and the nature run: needs the package smrt.


rule study_convolution_smrt:
    input:
        code=imported_by("study_convolution_smrt.py"),
    output:
        table="results/studies/convolution/smrt.csv",
        curves="results/studies/convolution/smrt_waveforms.csv",
    log:
        "logs/study_convolution_smrt.log",
    benchmark:
        "results/benchmarks/study_convolution_smrt/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        reference=config["reference"],
    message:
        "waveforms of SMRT, of the nature run, and the best fits of eq. (1)"
    script:
        "../scripts/study_convolution_smrt.py"


rule study_convolution:
    input:
        rules.study_convolution_smrt.output,
    message:
        "SMRT beside the convolution model; the figure of the target convolution takes it in when that is run next"
