"""Sources of flight and benchmark, checked before the first job.

Readers are imported where they are used, since every start of the workflow runs this module but
needs the readers of one source only.
"""

import hashlib
import json
import os
from pathlib import Path

# What the head process found in the table of frames, for the processes of its jobs, in the folder
# of the run. A table of 100,000 frames takes seconds to read and check, a line of it nothing.
KEPT = Path(".snakemake/frames")
ROLES = ("statistics", "train", "test")  # roles that need a frame; validation may have none


def observed(config, is_job=False):
    """Own frames (rows of their table) or pairs of images, by role; empty for the reference.

    The process of a job takes own frames as the head process found them.
    """
    source = config["source"]
    own = config["import"]
    if source == "reference":
        check_reference(config["reference"], config["flight"])
        return {}
    if source == "png_pairs":
        pairs = own["pairs"]
        return own_pairs(pairs["folder"], pairs["lists"])
    frames = kept(own["frames"], ROLES, 0) if is_job else None
    if frames is None:
        frames = own_frames(own["frames"])
        keep(own["frames"], ROLES, [frames])
    return frames


def _kept_file(path_to_table, purpose):
    """File of what was found in a table, which has another name once the table was changed."""
    table = os.stat(path_to_table)
    state = [os.path.abspath(path_to_table), table.st_mtime_ns, table.st_size, purpose]
    return KEPT / f"{hashlib.sha256(repr(state).encode()).hexdigest()[:16]}.jsonl"


def keep(path_to_table, purpose, found):
    """Write what the head process found in the table for some purpose, a line for each job."""
    path = _kept_file(path_to_table, purpose)
    if path.exists():
        return
    KEPT.mkdir(parents=True, exist_ok=True)
    aside = path.with_suffix(f".{os.getpid()}")
    aside.write_text("".join(f"{json.dumps(each)}\n" for each in found))
    aside.replace(path)


def kept(path_to_table, purpose, number):
    """What `keep` wrote for a job; None if it did not, or the table was changed since."""
    try:
        with _kept_file(path_to_table, purpose).open() as lines:
            return next((json.loads(line) for n, line in enumerate(lines) if n == number), None)
    except OSError:
        return None


def check_reference(reference, flight):
    """ValueError if settings of the reference flight contradict each other or frames do not fit."""
    from reference import checked_settings
    from reference.line import line_length_km

    try:
        checked_settings(reference)
    except ValueError as error:
        msg = f"config: reference: {error}"
        raise ValueError(msg) from None
    n_frames = flight["n_frames"]
    n_range_lines = flight["n_range_lines"]
    length_km = n_frames * n_range_lines * reference["radar"]["line_spacing_m"] / 1e3
    longest_km = line_length_km()
    if length_km > longest_km:
        msg = (
            "config: flight.n_frames: expected frames that fit on the line of "
            f"{longest_km:.0f} km, got {n_frames} of {n_range_lines} lines, {length_km:.0f} km"
        )
        raise ValueError(msg)


def own_frames(path_to_table):
    """Rows of the table of frames, dicts in lists by role; ValueError if a role lacks a frame.

    Frames to track are left out: flight and benchmark know nothing of them.
    """
    from snowsim.io.frames import TRACK, read_frames

    table = read_frames(path_to_table)
    frames = {role: rows.to_dict("records") for role, rows in table.groupby("role")}
    frames.pop(TRACK, None)
    for role in ROLES:
        if role not in frames:
            msg = f"{path_to_table}: role: expected at least one frame for {role}, found none"
            raise ValueError(msg)
    return frames


def frames_to_track(path_to_table, per_job):
    """Rows of the table of frames that are to be tracked, a list of dicts for each job.

    A job has about `per_job` frames. A segment is never divided between jobs, however long it is,
    since layers keep their names along it. Frames whose files name no segment may be of one.
    """
    from snowsim.echogram import named_frame
    from snowsim.io.frames import TRACK, read_frames

    table = read_frames(path_to_table)
    segments = {}
    for row in table[table["role"] == TRACK].to_dict("records"):
        segment, _ = named_frame(row["echogram"])
        segments.setdefault(segment, []).append(row)
    jobs = []
    for rows in segments.values():
        if not jobs or len(jobs[-1]) + len(rows) > per_job:
            jobs.append([])
        jobs[-1] += rows
    if not jobs:
        msg = f"{path_to_table}: role: expected at least one frame for {TRACK}, found none"
        raise ValueError(msg)
    return jobs


def own_tracker(name):
    """Files of someone's own tracker, its network and its card; none of one of the package."""
    return [name, str(Path(name).with_suffix(".json"))] if name.endswith(".onnx") else []


def check_tracker(name):
    """ValueError unless `import.tracker` is a file NAME.onnx or a tracker of the package."""
    shipped = [path.stem for path in (Path(__file__).parents[2] / "snowsim/data").glob("*.onnx")]
    if not own_tracker(name) and name not in shipped:
        known = ", ".join(sorted(shipped))
        msg = f"config: import.tracker: expected {known}, or a file NAME.onnx, got {name}"
        raise ValueError(msg)


def shipped_tracker(name):
    """Files of a tracker that comes with the package, by their paths in the checkout; or none."""
    return [] if own_tracker(name) else [f"snowsim/data/{name}{end}" for end in (".onnx", ".json")]


def frame_files(row):
    """All files that a row is read from, with the flags of its echogram and names of its layers."""
    from snowsim.io.layers import find_organizer

    files = echogram_files(row["echogram"])
    if row["layers"]:
        files += stored_files(row["layers"])
        if organizer := find_organizer(row["layers"]):
            files.append(str(organizer))
    return files


def echogram_files(path):
    """Files of an echogram, and its supplement if there is one."""
    from snowsim.io.echograms import find_supplement

    supplement = find_supplement(path)
    return stored_files(path) + ([str(supplement)] if supplement else [])


def stored_files(path):
    """A file, or all files of a Zarr store: its folder keeps its time when a chunk changes."""
    files = sorted(Path(path).rglob("*")) if Path(path).is_dir() else []
    return [str(path), *(str(file) for file in files if file.is_file())]


def frame_inputs(row):
    """Inputs of a rule that imports the frame of a row; `files` lists all files it is read from."""
    return {"echogram": row["echogram"], "layers": row["layers"], "files": frame_files(row)}


def own_pairs(folder, lists):
    """A `PairSet` for each split that has a list; ValueError if a scene is in two lists."""
    from snowsim.io.pairs import PairSet

    if folder is None:
        msg = "config: import.pairs.folder: expected a folder of the published benchmark, got null"
        raise ValueError(msg)
    pairs = {split: PairSet(Path(folder) / name) for split, name in lists.items() if name}
    seen = {}
    for split, scenes in pairs.items():
        for scene in scenes.names:
            if scene in seen:
                msg = (
                    f"{folder}: {lists[split]}: expected scenes that are in no other list, "
                    f"found {scene} in {lists[seen[scene]]} too"
                )
                raise ValueError(msg)
            seen[scene] = split
    return pairs


def copies_held_out(rows):
    """A message for each scene whose image is that of a scene of another split."""
    first = {}
    failed = []
    for row in rows:
        other = first.setdefault(row["digest"], row)
        if other["split"] != row["split"]:
            failed.append(
                f"{row['split']}: {row['name']}: expected an image that is in no other list, found "
                f"that of {other['name']} of {other['split']}"
            )
    return failed


def check_lists(lists, *, contrast_db, spacing):
    """Table of every scene in the lists, with its split.

    One ValueError names all scenes that cannot be read. All scenes must have the same number of
    range lines; without `contrast_db`, train scenes must say what their grey levels stand for. What
    a folder says of its range bin and line spacing must be what the configuration says, `spacing`.
    """
    import pandas as pd

    from snowsim.io.pairs import SPACING_FILE, PairSet

    rows = []
    failed = []
    for split, path in lists.items():
        try:
            scenes = PairSet(path)
            checked = scenes.check()
        except ValueError as error:
            failed.append(f"{path}: {error}")
            continue
        for folder, told in scenes.spacing.items():
            for name, value in told.items():
                key, said = spacing[name]
                if abs(value / said - 1) > 1e-6:
                    told_by = f"as {folder / SPACING_FILE} says"
                    failed.append(f"config: {key}: expected {value:g}, {told_by}, got {said:g}")
        rows += [{"split": split, **row} for row in checked]
    failed += copies_held_out(rows)
    if failed:
        raise ValueError("\n".join(failed))
    table = pd.DataFrame(rows).drop(columns="digest")
    without_db = table.loc[(table["split"] == "train") & ~table["tells_db"], "name"]
    if contrast_db is None and len(without_db):
        scenes = f"{len(without_db)} train scenes, {without_db.iloc[0]} the first,"
        msg = (
            f"{scenes} do not hold their decibels: import.pairs.contrast_db: "
            "expected decibels from the noise floor to 255, got null"
        )
        raise ValueError(msg)
    widths = table.groupby("split")["n_range_lines"].first()
    if widths.nunique() > 1:
        found = ", ".join(f"{split} {width}" for split, width in widths.items())
        msg = f"range lines of a scene: expected the same in all lists, found {found}"
        raise ValueError(msg)
    return table
