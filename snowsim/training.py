"""Parts that all trainings share: steps, precision, states to keep and to restore."""

import math
import warnings

import torch
from torch.utils.data import DataLoader

READ_EVERY = 50  # [steps] between readings of the losses on a GPU; each waits for the device
# Most shapes of batches for which a step is captured: 300 heights at four scales. For others the
# function is called.
MOST_GRAPHS = 1200
N_AHEAD = 4  # batches that each process makes ahead


def is_gpu(device):
    """True if a device is a GPU."""
    return torch.device(device).type == "cuda"


def check_device(device):
    """ValueError if a device is a GPU and there is none."""
    if is_gpu(device) and not torch.cuda.is_available():
        msg = f"device {device}: expected a GPU that this build of torch can use, found none"
        raise ValueError(msg)


class Step:
    """A step of a training, as a function of a batch; on a GPU it is replayed, not called.

    A step of these networks starts some hundred short kernels, and starting them takes a GPU longer
    than their arithmetic. There the function is captured as a CUDA graph when a shape of its batch
    is first met; later batches of that shape are copied to where the graph reads them.

    Parameters
    ----------
    function : callable
        ``function(batch)`` of nested dicts of tensors on the device gives a tensor of losses. What
        else it changes are tensors of `optimisers`, all in place; it does not wait for the device.
    optimisers : sequence of torch.optim.Optimizer
        They have moments (`adaptive`) and their weights gradients (`Resumable`) already.
    device : str
    """

    def __init__(self, function, optimisers, device):
        self._function = function
        self._optimisers = optimisers
        self._device = device
        self._captured = {}
        self._pool = torch.cuda.graph_pool_handle() if is_gpu(device) else None

    def __call__(self, batch):
        """Take the step on a batch, tensors in main memory; its losses, a tensor."""
        if not is_gpu(self._device):
            return self._function(batch)
        shapes = tuple((tensor.shape, tensor.dtype) for tensor in leaves(batch))
        if shapes not in self._captured:
            held = on_device(batch, self._device)
            if len(self._captured) == MOST_GRAPHS:
                return self._function(held)
            self._captured[shapes] = self._capture(held)
        held, graph, losses = self._captured[shapes]
        for tensor, value in zip(leaves(held), leaves(batch), strict=True):
            tensor.copy_(value, non_blocking=True)
        graph.replay()
        # The next replay writes over them.
        return losses.clone()

    def _capture(self, held):
        """The tensors that a graph reads, `held`, the graph, and the losses that it writes."""
        changed = [tensor for one in self._optimisers for tensor in changed_by(one)]
        before = [tensor.detach().clone() for tensor in changed]
        stream = torch.cuda.Stream()
        stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(stream):
            # CUDA graphs ask for some calls of a step before it is captured.
            for _ in range(3):
                self._function(held)
        torch.cuda.current_stream().wait_stream(stream)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph, pool=self._pool):
            losses = self._function(held)
        # Steps taken to warm up do not count.
        with torch.no_grad():
            for tensor, value in zip(changed, before, strict=True):
                tensor.copy_(value)
        return held, graph, losses


def leaves(batch):
    """Tensors of nested dicts, in order."""
    for value in batch.values():
        if isinstance(value, dict):
            yield from leaves(value)
        else:
            yield value


def on_device(batch, device):
    """Nested dicts of tensors, copied to a device."""
    if isinstance(batch, dict):
        return {key: on_device(value, device) for key, value in batch.items()}
    return batch.detach().to(device)


def changed_by(optimiser):
    """Tensors that an optimiser's step changes: weights, gradients and moments."""
    for weight in weights_of(optimiser):
        yield weight
        yield weight.grad
        yield from optimiser.state.get(weight, {}).values()


def adaptive(kind, groups, rate, device, **options):
    """An optimiser of `kind`, torch.optim.Adam or AdamW, whose steps can be captured on a GPU."""
    on_gpu = is_gpu(device)
    optimiser = kind(groups, lr=rate, fused=True, capturable=on_gpu, **options)
    if on_gpu:
        for group in optimiser.param_groups:
            group["lr"] = torch.tensor(rate, device=device)
        for weight in weights_of(optimiser):
            # As at the first step, which would make them anew.
            optimiser.state[weight] = {
                "step": torch.zeros((), device=device),
                "exp_avg": torch.zeros_like(weight),
                "exp_avg_sq": torch.zeros_like(weight),
            }
    return optimiser


def weights_of(optimiser):
    """Weights that an optimiser changes, in the order of their numbers in its state."""
    return [weight for group in optimiser.param_groups for weight in group["params"]]


def set_rate(group, rate):
    """Set the learning rate of a group of an optimiser; a tensor, which a graph reads, in place."""
    if torch.is_tensor(group["lr"]):
        group["lr"].fill_(rate)
    else:
        group["lr"] = rate


class Batches:
    """Batches of a training by number of the step; a ValueError is returned, not raised.

    Raised in a process that makes batches, its message would be the whole traceback.
    """

    def __init__(self, batch_at):
        self._batch_at = batch_at

    def __getitem__(self, step):
        try:
            return self._batch_at(step)
        except ValueError as error:
            return error


def batches(batch_at, first, n_steps, *, device, n_workers):
    """Batches ``batch_at(step)`` of steps `first` to `n_steps`, in order.

    `n_workers` processes make them ahead; 0: they are made when asked for. A batch is a function of
    its step alone, so both give the same.
    """
    ahead = {}
    if n_workers:
        # Forked, they share the open files and scenes in memory.
        ahead = {"prefetch_factor": N_AHEAD, "multiprocessing_context": "fork"}
    loader = DataLoader(
        Batches(batch_at),
        batch_size=None,
        sampler=range(first, n_steps),
        num_workers=n_workers,
        pin_memory=is_gpu(device),
        **ahead,
    )
    for batch in loader:
        if isinstance(batch, ValueError):
            raise batch
        yield batch


def run_steps(training, batch_at, take, names, *, n_workers):
    """Run the steps that a training still has; yields the steps taken and the losses by name.

    ``take(batch)`` runs one step and gives its losses. On a CPU every step yields. Reading losses
    from a GPU waits for the device: there every `READ_EVERY` steps, and the last, yield the mean of
    the losses since the reading before. FloatingPointError if a loss is not finite.
    """
    n_steps = training.settings.n_steps
    every = READ_EVERY if is_gpu(training.device) else 1
    total, n_added = 0, 0
    ready = batches(batch_at, training.step, n_steps, device=training.device, n_workers=n_workers)
    for batch in ready:
        total = total + take(batch)
        n_added += 1
        training.step += 1
        if training.step % every and training.step < n_steps:
            continue
        losses = dict(zip(names, (total / n_added).tolist(), strict=True))
        if not all(map(math.isfinite, losses.values())):
            msg = f"training diverged at step {training.step}: {losses}"
            raise FloatingPointError(msg)
        total, n_added = 0, 0
        yield training.step, losses


def arithmetic(device, precision):
    """Context in which networks compute in `precision`, `float32` or `bfloat16`.

    Weights are always float32. A processor without AVX-512 would emulate bfloat16: there networks
    compute in float32, with a UserWarning.
    """
    kind = torch.device(device).type
    is_bfloat16 = precision == "bfloat16"
    # Names that torch gives to the capability of x86-64 processors without AVX-512.
    without_avx512 = ("DEFAULT", "NO AVX", "AVX", "AVX2")
    is_emulated = kind == "cpu" and torch.backends.cpu.get_cpu_capability() in without_avx512
    if is_bfloat16 and is_emulated:
        msg = (
            "bfloat16 is ten times slower than float32 on a processor without AVX-512: computing "
            "in float32, which moves numbers as another processor does"
        )
        warnings.warn(msg, stacklevel=2)
    return torch.autocast(kind, torch.bfloat16, enabled=is_bfloat16 and not is_emulated)


def load_weights(network, weights, name):
    """The network, with weights (dict of arrays) copied into it.

    ValueError, naming the network, if names or shapes differ.
    """
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    got = {key: tuple(value.shape) for key, value in weights.items()}
    for key in sorted(expected | got):
        if expected.get(key) != got.get(key):
            shapes = f"expected {key} of shape {expected.get(key)}, got {got.get(key)}"
            msg = f"{name}: {shapes}: other settings made it"
            raise ValueError(msg)
    network.load_state_dict({key: torch.as_tensor(value) for key, value in weights.items()})
    return network


class Resumable:
    """Settings, seed, device, networks and optimisers of a training, and `step`, steps taken.

    A training resumes from its `state`, `step` and seed, since what a step draws depends on seed
    and step alone. `what` names it in errors. `networks` are by name, with their first weights;
    `optimisers` are added later.
    """

    def __init__(self, what, settings, seed, device, networks):
        self._what = what
        self.settings = settings
        self.seed = seed
        self.device = device
        self.step = 0
        self.networks = networks
        self.optimisers = {}
        for network in networks.values():
            network.to(device=device, memory_format=torch.channels_last)
            for weight in network.parameters():
                # On a GPU a graph adds to these, in place.
                weight.grad = torch.zeros_like(weight)

    def state(self):
        """All that a step changes, except `step` itself, as nested dicts of CPU tensors."""
        state = {name: network.state_dict() for name, network in self.networks.items()}
        for name, optimiser in self.optimisers.items():
            state[name] = optimiser.state_dict()["state"]
        return on_device(state, "cpu")

    def restore(self, state, step):
        """Continue from a `state`, as arrays, that was kept after `step` steps.

        ValueError if it was made by other settings.
        """
        for name, network in self.networks.items():
            load_weights(network, state.get(name, {}), f"{self._what} {name}")
        for name, optimiser in self.optimisers.items():
            load_moments(optimiser, state.get(name, {}))
        self.step = step


def load_moments(optimiser, moments):
    """Copy moments, dicts of arrays by number of the weight, into an optimiser.

    Before the first step there are none.
    """
    weights = weights_of(optimiser)
    for index, values in moments.items():
        weight = weights[int(index)]
        for key, value in values.items():
            # Moments are laid out in memory as the weights are; the number of steps is a scalar.
            like = weight if value.ndim else weight.new_empty(())
            optimiser.state[weight][key] = copy_like(like, value)


def copy_like(weight, values):
    """An array as a tensor of the shape and device of a weight, laid out in memory as it is."""
    return torch.empty_like(weight).copy_(torch.as_tensor(values))
