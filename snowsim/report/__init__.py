"""The report: what a run measured beside what the paper states, verdicts by stated rules, and a gallery of scenes."""
