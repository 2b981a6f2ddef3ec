# The workflow lies where the catalogue of workflows looks for it. An `include:` would leave its default target out.
workflow.include("workflow/Snakefile", overwrite_default_target=True)
