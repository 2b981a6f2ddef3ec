"""What a run cost, stage by stage, from the benchmark files of its jobs."""

import pandas as pd

GIBIBYTE_MB = 1024


def stage_costs(jobs, stages):
    """Cost of every stage and of every rule in it.

    Parameters
    ----------
    jobs : pandas.DataFrame
        A row per job: `rule`, `s` [wall seconds], `cpu_time` [s], `max_rss` [MB].
    stages : dict
        Rule -> stage; rules that are not in it are left out, their files are of an older run.

    Returns
    -------
    list of dict
        `stage`, `n_jobs`, `wall_s`, `cpu_s`, `memory_gb` (largest of a job) and `rules`, the same per rule, in the
        order of `stages`.
    """
    jobs = jobs[jobs["rule"].isin(list(stages))]
    numbers = {name: pd.to_numeric(jobs[name], errors="coerce") for name in ("s", "cpu_time", "max_rss")}
    jobs = jobs.assign(**numbers)
    found = []
    for stage in dict.fromkeys(stages.values()):
        rules = [rule for rule, of in stages.items() if of == stage]
        parts = [_cost(rule, jobs[jobs["rule"] == rule]) for rule in rules if (jobs["rule"] == rule).any()]
        if parts:
            whole = _cost(stage, jobs[jobs["rule"].isin(rules)])
            found.append({"stage": stage, **{k: v for k, v in whole.items() if k != "rule"}, "rules": parts})
    return found


def _cost(name, jobs):
    return {
        "rule": name,
        "n_jobs": len(jobs),
        "wall_s": float(jobs["s"].sum()),
        # Jobs that end between two looks of the clock have no CPU time on file.
        "cpu_s": float(jobs["cpu_time"].sum()),
        "memory_gb": float(jobs["max_rss"].max()) / GIBIBYTE_MB,
    }
