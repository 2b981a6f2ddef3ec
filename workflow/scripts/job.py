"""The frame of every script: its log, one line for bad input, and the memory it needs."""

import atexit
import gc
import logging
import sys
import time
import traceback
import warnings
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import psutil
from tqdm import tqdm

# The package beside the workflow is the one that runs. It need not be installed: a conda
# environment holds its dependencies only.
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]

from lib.progress import progress  # noqa: E402, F401
from snowsim.io.files import one_line  # noqa: E402

logger = logging.getLogger("snowsim")

# Modules live as long as the process, so that to search them for garbage is a waste: a fifth of the
# time of imports, and a second at the end of a process with torch.
if hasattr(sys.modules["__main__"], "snakemake"):
    gc.disable()
    atexit.register(gc.freeze)


def checkout_files(names):
    """Paths of files of the checkout, which a rule names in its params."""
    return [ROOT / name for name in names]


@contextmanager
def job(snakemake):
    """Log to the rule's file; bad input or a full disk ends the job with one line on stderr.

    Other errors pass through, after the log has them.
    """
    path = Path(str(snakemake.log))
    path.parent.mkdir(parents=True, exist_ok=True)
    logging.basicConfig(
        filename=path,
        filemode="w",
        level=logging.INFO,
        format="%(asctime)s %(message)s",
        force=True,
    )
    gc.freeze()
    gc.enable()
    begin = time.perf_counter()
    try:
        check_memory(snakemake.resources.get("mem_mb", 0))
        with warnings.catch_warnings():
            warnings.showwarning = partial(note_warning, snakemake.rule)
            yield logger
    except (ValueError, OSError, FloatingPointError) as error:  # the last if a training diverged
        logger.error(traceback.format_exc())
        logger.error("error: %s", error)
        # On a line of its own, even beside a progress bar.
        tqdm.write(f"error: {snakemake.rule}: {error}", file=sys.stderr)
        sys.exit(1)
    except BaseException as error:
        logger.error(traceback.format_exc())
        logger.error("error: %s: %s", type(error).__name__, error)
        raise
    logger.info("done in %.1f s", time.perf_counter() - begin)


def note_warning(rule, message, category, *place, **how):
    """Write a warning to the log, where the report finds it, and to stderr."""
    kind = "" if category is UserWarning else f"{category.__name__}: "
    line = f"{kind}{one_line(message)}"
    logger.warning("warning: %s", line)
    tqdm.write(f"warning: {rule}: {line}", file=sys.stderr)


def check_memory(mem_mb):
    """ValueError if less memory is available than the rule asks for."""
    available = psutil.virtual_memory().available / 2**20
    if available < mem_mb:
        msg = f"memory: expected at least {mem_mb} MB available, got {available:.0f} MB"
        raise ValueError(msg)
