"""Mean power of random profiles: errors of what `snowsim.simulate` makes of them, and cost."""

from functools import partial

from main_path import run

from evaluation.lib.profiles import profile_table
from snowsim.io.files import write_table
from snowsim.seeding import random_stream


def study_profiles(table, *, seed, n_profiles):
    write_table(table, profile_table(n_profiles, partial(random_stream, seed, "study_profiles")))


run(study_profiles)
