"""What every script shares: a log that ends with the error, one line for bad input, progress of long work."""

import logging
import sys
import time
import traceback
from contextlib import contextmanager
from pathlib import Path

from tqdm import tqdm

logger = logging.getLogger("snowsim")


@contextmanager
def job(snakemake):
    """Log to the rule's log file; bad input or a full disk ends the job with one plain line on stderr."""
    path = Path(str(snakemake.log))
    path.parent.mkdir(parents=True, exist_ok=True)
    logging.basicConfig(filename=path, filemode="w", level=logging.INFO, format="%(asctime)s %(message)s", force=True)
    begin = time.perf_counter()
    try:
        yield logger
    except (ValueError, OSError, FloatingPointError) as error:  # the last: a training diverged
        logger.error(traceback.format_exc())
        logger.error("error: %s", error)
        sys.stderr.write(f"error: {snakemake.rule}: {error}\n")
        sys.exit(1)
    except BaseException:
        logger.error(traceback.format_exc())
        raise
    logger.info("done in %.1f s", time.perf_counter() - begin)


def progress(iterable, description, total=None, initial=0):
    """Iterate with a progress bar on stderr, redrawn at most every few seconds where it is no terminal."""
    interval = 0.5 if sys.stderr.isatty() else 15
    return tqdm(
        iterable, description, total=total, initial=initial, mininterval=interval, miniters=1, dynamic_ncols=True
    )
