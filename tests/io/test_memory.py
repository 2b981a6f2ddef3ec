"""A flight is fitted one frame at a time."""

import tracemalloc

from made_up import made_up_frame

from snowsim.statistics import fit


def test_memory_grows_with_sums_over_lines_and_not_with_frames(planted, rng):
    power, layer_bins = planted.level()

    def frames(n_frames):
        for minute in range(n_frames):
            yield made_up_frame(rng.gamma(5, power / 5), layer_bins, minute=minute)

    peak_bytes = []
    for n_frames in (8, 16):
        tracemalloc.start()
        fit(frames(n_frames))
        peak_bytes.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # Means of 20 lines, and of blocks, are a tenth of a frame.
    assert peak_bytes[1] - peak_bytes[0] < 8 * power.nbytes / 4
