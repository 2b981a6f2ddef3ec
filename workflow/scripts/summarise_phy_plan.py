"""What the plans of all rendered label scenes left out, bound and cost, from the notes kept with the scenes."""

import pandas as pd
from job import job, progress

from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet

QUANTITIES = ("plan_share", "plan_cost_normals", "plan_bound_db")


def summarise(paths_to_scenes, path_to_plans, path_to_table):
    with SceneSet(paths_to_scenes) as scenes:
        plans = pd.DataFrame([{"scene": scene.name, **scene.notes} for scene in progress(scenes, "plans")])
    plans = plans[["scene", *(name for name in plans.columns if name.startswith("plan_"))]]
    table = plans[list(QUANTITIES)].agg(["min", "mean", "max"]).T.rename_axis("quantity").reset_index()
    table["n_scenes"] = len(plans)
    # Of all pixels times layers of all scenes together: large scenes weigh more than in the mean of shares.
    table["of_all_terms"] = [plans["plan_terms"].sum() / plans["plan_terms_full"].sum(), None, None]
    write_table(path_to_plans, plans)
    write_table(path_to_table, table)


if __name__ == "__main__":
    with job(snakemake):
        summarise(snakemake.input.scenes, snakemake.output.plans, snakemake.output.table)
