"""Waveforms of SMRT's nadir altimetry solver, of the nature run, and the best fits of eq. (1)."""

from main_path import run

from evaluation.lib.smrt_waveforms import compare_waveforms
from snowsim.io.files import write_table
from snowsim.reference import checked_settings


def study_convolution_smrt(table, curves, *, reference):
    errors, waveforms = compare_waveforms(checked_settings(reference))
    write_table(table, errors)
    write_table(curves, waveforms)


run(study_convolution_smrt)
