"""Statistics and layers are the same on any x86-64 processor, pixels and networks nearly so.

Other processors are played by what libraries let choose: kernels of OpenBLAS, instructions of
NumPy, Numba and PyTorch.
"""

import os
import subprocess
import sys

import numpy as np
import torch
from processes import ROOT

# Where the processor has no AVX-512, which these kernels need, its own.
HAS_AVX512 = torch.backends.cpu.get_cpu_capability().startswith("AVX512")
PLAIN = {"OPENBLAS_CORETYPE": "SkylakeX"} if HAS_AVX512 else {}
# Of 2013 with AVX2, without AVX-512; without AVX2, 3 of 2 million pixels of frames differ.
OLDER = {
    "OPENBLAS_CORETYPE": "Haswell",
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL",
    "NUMBA_CPU_NAME": "generic",
    "ATEN_CPU_CAPABILITY": "default",
    "ONEDNN_MAX_CPU_ISA": "AVX2",
}
N_SCENES = 8
COMPUTED = """
import sys
sys.path.insert(0, "workflow")
import numpy as np
import snowsim
from snowsim.echogram import Scene
from reference import (
    checked_settings, draw_climate, draw_complex_segment, draw_frame,
)
from snowsim.seeding import random_stream
from snowsim.statistics import doppler_spectra, fit
from snowsim.io.files import read_dataset
from snowsim.tracker import Settings, Training, train_steps

settings = checked_settings({"radar": {"n_range_bins": 500}})
climate = draw_climate(settings, rng=np.random.default_rng(1))
frames = [
    draw_frame(i, 2, 1024, climate=climate, settings=settings, rng=np.random.default_rng(i))
    for i in range(2)
]
found = {"frames": np.concatenate([echogram["Data"].values for echogram, _ in frames], axis=1)}
for name, variable in fit(frames).variables.items():
    found[f"statistics {name}"] = variable.values
segment = draw_complex_segment(climate=climate, settings=settings, rng=np.random.default_rng(9))
layer_bins = (segment["layer_twtt"].values - segment["twtt"].values[0]) / 2.886e-10
amplitude = segment["Real"].values + 1j * segment["Imaginary"].values
found["statistics of Doppler"] = np.array(doppler_spectra(amplitude, layer_bins, 0.3))
drawn = snowsim.scenes(int(sys.argv[2]), rng=7)
scenes = [drawn.scene(i) for i in range(len(drawn))]
found["layers"] = np.concatenate([scene.layer_bins.ravel() for scene in scenes])
# Notes of layers; those on PHY's plans tell costs and bounds of pixels.
found["notes"] = np.array(
    [str({key: scene.notes[key] for key in scene.notes if "plan" not in key}) for scene in scenes]
)
found["pixels"] = np.concatenate([scene.image.ravel() for scene in scenes])
training = Training(Settings(n_steps=10), seed=1)
chosen = [scene for scene in scenes if np.isfinite(scene.layer_bins[1:]).any()]
endless = {i: chosen[i % len(chosen)] for i in range(40)}
found["losses"] = np.array([losses["total"] for _, losses in train_steps(training, endless)])
np.savez(sys.argv[1], **found)
"""


def computed(folder, processor):
    """What a process on such a processor computes, arrays by name."""
    words = [sys.executable, "-W", "ignore", "-c", COMPUTED, str(folder / "found.npz")]
    environment = os.environ | {"OMP_NUM_THREADS": "1"} | processor
    subprocess.run([*words, str(N_SCENES)], cwd=ROOT, env=environment, check=True)
    with np.load(folder / "found.npz") as found:
        return dict(found)


def test_statistics_and_layers_are_the_same_on_any_processor(tmp_path):
    here, there = (computed(tmp_path, processor) for processor in (PLAIN, OLDER))
    assert here.keys() == there.keys()
    differ = [name for name in here if here[name].tobytes() != there[name].tobytes()]
    assert set(differ) <= {"pixels", "losses"}
    # A pixel is a whole grey level of some 0.15 dB, and mean powers in float32 end in other last
    # bits: 1e-7 of 30 dB is one level in 5e6 for each of a few roundings. Seen: 10 in a million.
    changed = here["pixels"].astype(int) - there["pixels"]
    assert np.abs(changed).max() <= 1
    assert (changed != 0).mean() < 5e-5
    # Products in bfloat16, here but not there, keep three digits.
    np.testing.assert_allclose(there["losses"], here["losses"], rtol=2e-2)
