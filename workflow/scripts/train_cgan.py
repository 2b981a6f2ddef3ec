"""Train the conditional GAN on the observed train scenes and their layers."""

import dataclasses

from job import logger, run
from torch.utils.data import Subset

from lib.cgan_health import faults
from lib.cgan_training import Collapsed, Validation, held_out, sample_scenes
from lib.guides import Guides
from lib.scope import scope_of
from lib.training import TrainingRun, check_memory, enough_memory
from snowsim.cgan import Settings, Training, least_bytes, train_steps
from snowsim.io.files import read_dataset, write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.patches import check_trainable


def train(
    scenes, generator, losses, scores, samples, labels=(), statistics=None,
    *, phy=None, seed, device, settings, validation, on_collapse, source, checkpoint, checkpoint_steps, events,
):  # fmt: skip
    settings = Settings(**settings)
    made_of = {
        "settings": dataclasses.asdict(settings),
        "seed": seed,
        "data": fingerprint([*scenes, *labels]),
    }
    made_of |= {"validation": validation}
    what = f"a cGAN of width {settings.width}"
    check_memory(least_bytes(settings), what)
    with SceneSet(scenes) as observed, SceneSet(labels) as drawn, enough_memory(what):
        train_numbers, held_numbers = held_out(len(observed), validation["n_scenes"], seed=seed)
        train_scenes, held_scenes = (
            Subset(observed, train_numbers),
            [observed[number] for number in held_numbers],
        )
        for scene in held_scenes:
            check_trainable(scene)
        training = Training(settings, seed=seed, device=device)
        guides, validated = None, held_scenes
        if settings.method == "guided":
            if not labels:
                msg = "cgan.training.method: a guided generator needs label sets: see studies.cgan.renderers"
                raise ValueError(msg)
            guides = Guides(drawn, read_dataset(statistics), phy, seed=seed)
            validated = [guides[number] for number in range(len(held_scenes))]
        options = {"observed": held_scenes, "goes_on": on_collapse == "go_on"}
        check = Validation(training, validated, validation, **options)
        unfinished = {"kind": "unfinished cgan training", **made_of}
        kept = {"every_steps": checkpoint_steps, "path_to_events": events, "validation": check}
        with TrainingRun(training, checkpoint, unfinished, **kept) as taken:
            check.run, collapse = taken, None
            try:
                taken.take(train_steps(training, train_scenes, guides), settings.n_steps, "cGAN")
            except (Collapsed, FloatingPointError) as error:
                taken.discard()
                if on_collapse == "fail" or taken.best is None:
                    msg = f"cGAN training collapsed at {error}"
                    raise ValueError(msg) from error
                collapse = str(error)
                logger.warning(
                    "collapsed at %s; the weights after step %d are kept", collapse, taken.best_step
                )
            best = taken.scores().set_index("step").loc[taken.best_step]
            if best["n_faults"] > 0:
                collapse = f"step {taken.best_step}: {'; '.join(faults(best.to_dict(), dropout=settings.dropout))}"
                logger.warning("collapsed at %s; these weights are kept all the same", collapse)
            metadata = {"kind": "cgan generator", **made_of, "step": taken.best_step}
            metadata |= {
                "steps_taken": training.step,
                "collapse": collapse,
                "scope": scope_of(train_scenes),
            }
            write_table(losses, taken.losses())
            write_table(scores, taken.scores())
            write_scenes(samples, sample_scenes(validated, taken.samples), {"synthetic": source})
            write_model(generator, taken.best, metadata)


run(train)
