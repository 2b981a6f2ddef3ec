"""Parts that all trainings share: steps, batches, precision, and states to save and restore."""

import math
import warnings

import torch
from torch.utils.data import DataLoader

READ_EVERY = 50  # [steps] between readings of the losses on a GPU, which wait for the device
# Largest number of batch shapes for which a step is captured: 300 heights at four scales. For
# further shapes the function is called.
MOST_GRAPHS = 1200
N_AHEAD = 4  # batches that each process prepares in advance


def is_gpu(device):
    """True if a device is a GPU."""
    return torch.device(device).type == "cuda"


def check_device(device):
    """Raise ValueError if a device is a GPU and torch finds none."""
    if is_gpu(device) and not torch.cuda.is_available():
        msg = f"device {device}: expected a GPU that this build of torch can use, found none"
        raise ValueError(msg)


class Step:
    """Training step, a function of a batch; on a GPU, a CUDA graph replaces calls of the function.

    A step of these networks starts some hundred short kernels. On a GPU, starting them takes longer
    than their arithmetic. There, the first batch of each shape captures the function as a graph.
    Later batches of that shape are copied to the memory that the graph reads.

    Parameters
    ----------
    function : callable
        ``function(batch)`` returns a tensor of losses; `batch` is nested dicts of tensors on the
        device. Apart from this, it changes only tensors of `optimisers`, in place. It does not wait
        for the device.
    optimisers : sequence of torch.optim.Optimizer
        Their moments (`capturable_optimiser`) and gradients (`Resumable`) exist already.
    device : str
    """

    def __init__(self, function, optimisers, device):
        self._function = function
        self._optimisers = optimisers
        self._device = device
        self._captured = {}
        self._pool = torch.cuda.graph_pool_handle() if is_gpu(device) else None

    def __call__(self, batch):
        """Losses, a tensor, of one step on a batch whose tensors are in main memory."""
        if not is_gpu(self._device):
            return self._function(batch)
        shapes = tuple((tensor.shape, tensor.dtype) for tensor in tensors_of(batch))
        if shapes not in self._captured:
            graph_batch = on_device(batch, self._device)
            if len(self._captured) == MOST_GRAPHS:
                return self._function(graph_batch)
            self._captured[shapes] = self._capture(graph_batch)
        graph_batch, graph, losses = self._captured[shapes]
        for tensor, value in zip(tensors_of(graph_batch), tensors_of(batch), strict=True):
            tensor.copy_(value, non_blocking=True)
        graph.replay()
        # A copy: the next replay overwrites the losses.
        return losses.clone()

    def _capture(self, graph_batch):
        """Three parts of a graph: the batch that it reads, the graph, and the losses it writes."""
        state = [tensor for one in self._optimisers for tensor in state_tensors(one)]
        state_before = [tensor.detach().clone() for tensor in state]
        stream = torch.cuda.Stream()
        stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(stream):
            # CUDA graphs need some calls of a function before they capture it.
            for _ in range(3):
                self._function(graph_batch)
        torch.cuda.current_stream().wait_stream(stream)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph, pool=self._pool):
            losses = self._function(graph_batch)
        # The calls above must not count as training steps.
        with torch.no_grad():
            for tensor, value in zip(state, state_before, strict=True):
                tensor.copy_(value)
        return graph_batch, graph, losses


def tensors_of(batch):
    """Tensors in nested dicts, in order."""
    for value in batch.values():
        if isinstance(value, dict):
            yield from tensors_of(value)
        else:
            yield value


def on_device(batch, device):
    """Copy of nested dicts of tensors on a device."""
    if isinstance(batch, dict):
        return {key: on_device(value, device) for key, value in batch.items()}
    return batch.detach().to(device)


def state_tensors(optimiser):
    """Weights, gradients and moments, which a step of an optimiser changes."""
    for weight in weights_of(optimiser):
        yield weight
        yield weight.grad
        yield from optimiser.state.get(weight, {}).values()


def capturable_optimiser(kind, groups, rate, device, **options):
    """Optimiser of `kind`, torch.optim.Adam or AdamW, whose steps a CUDA graph can capture."""
    on_gpu = is_gpu(device)
    optimiser = kind(groups, lr=rate, fused=True, capturable=on_gpu, **options)
    if on_gpu:
        for group in optimiser.param_groups:
            group["lr"] = torch.tensor(rate, device=device)
        for weight in weights_of(optimiser):
            # The moments of a first step, which would otherwise allocate them itself.
            optimiser.state[weight] = {
                "step": torch.zeros((), device=device),
                "exp_avg": torch.zeros_like(weight),
                "exp_avg_sq": torch.zeros_like(weight),
            }
    return optimiser


def weights_of(optimiser):
    """Weights of an optimiser, in the order of their numbers in its state."""
    return [weight for group in optimiser.param_groups for weight in group["params"]]


def set_rate(group, rate):
    """Set the learning rate of a group of an optimiser, in place if a graph reads it."""
    if torch.is_tensor(group["lr"]):
        group["lr"].fill_(rate)
    else:
        group["lr"] = rate


class Batches:
    """Batches of a training by number of the step; a ValueError is returned, not raised.

    If a worker process raised it, the traceback would become part of its message.
    """

    def __init__(self, batch_at):
        self._batch_at = batch_at

    def __getitem__(self, step):
        try:
            return self._batch_at(step)
        except ValueError as error:
            return error


def batches(batch_at, first, n_steps, *, device, n_workers):
    """Batches ``batch_at(step)`` of steps `first` to ``n_steps - 1``, in order.

    `n_workers` processes prepare them in advance; with 0, each is made when it is needed. A batch
    depends on its step alone, so the number of processes does not matter.
    """
    worker_options = {}
    if n_workers:
        # Forked processes share the open files and the scenes in memory.
        worker_options = {"prefetch_factor": N_AHEAD, "multiprocessing_context": "fork"}
    loader = DataLoader(
        Batches(batch_at),
        batch_size=None,
        sampler=range(first, n_steps),
        num_workers=n_workers,
        pin_memory=is_gpu(device),
        **worker_options,
    )
    for batch in loader:
        if isinstance(batch, ValueError):
            raise batch
        yield batch


def run_steps(training, batch_at, take, names, *, n_workers):
    """Run the remaining steps of a training; yields the number of steps so far, and losses by name.

    ``take(batch)`` runs one step and returns its losses. On a CPU, every step yields. On a GPU,
    reading losses waits for the device. There, every `READ_EVERY` steps and at the end, the mean
    of the losses since the last reading is yielded. FloatingPointError if a loss is not finite.
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

    Weights are always float32. A processor without AVX-512 would emulate bfloat16, so networks
    compute in float32 there, with a UserWarning.
    """
    kind = torch.device(device).type
    is_bfloat16 = precision == "bfloat16"
    # Names in torch for the capability of x86-64 processors without AVX-512.
    without_avx512 = ("DEFAULT", "NO AVX", "AVX", "AVX2")
    is_emulated = kind == "cpu" and torch.backends.cpu.get_cpu_capability() in without_avx512
    if is_bfloat16 and is_emulated:
        msg = (
            "bfloat16 is ten times slower than float32 on a processor without AVX-512: computing "
            "in float32, which changes results as much as another processor does"
        )
        warnings.warn(msg, stacklevel=2)
    return torch.autocast(kind, torch.bfloat16, enabled=is_bfloat16 and not is_emulated)


def load_weights(network, weights, name):
    """The network, after `weights`, a dict of arrays, were copied into it.

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
    """Training that can be saved and resumed; `step` is the number of steps so far.

    It holds settings, seed, device, networks and optimisers. It resumes from its `state`, `step`
    and seed, since the random numbers of a step depend on seed and step alone. `what` is its name
    in errors. `networks` is a dict of networks with initial weights; `optimisers` are added later.
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
                # On a GPU, a graph adds to gradients in place.
                weight.grad = torch.zeros_like(weight)

    def state(self):
        """State of networks and optimisers, as nested dicts of CPU tensors.

        Together with `step` and the seed, it is all that a training resumes from.
        """
        state = {name: network.state_dict() for name, network in self.networks.items()}
        for name, optimiser in self.optimisers.items():
            state[name] = optimiser.state_dict()["state"]
        return on_device(state, "cpu")

    def restore(self, state, step):
        """Continue from a `state`, as arrays, that was saved after `step` steps.

        ValueError if the weights are those of networks with other settings.
        """
        for name, network in self.networks.items():
            load_weights(network, state.get(name, {}), f"{self._what} {name}")
        for name, optimiser in self.optimisers.items():
            load_moments(optimiser, state.get(name, {}))
        self.step = step


def load_moments(optimiser, moments):
    """Copy moments, dicts of arrays by number of the weight, into an optimiser.

    `moments` is empty if it was saved before the first step.
    """
    weights = weights_of(optimiser)
    for index, values in moments.items():
        weight = weights[int(index)]
        for key, value in values.items():
            # Moments are laid out in memory as the weights are; the number of steps is a scalar.
            like = weight if value.ndim else weight.new_empty(())
            optimiser.state[weight][key] = copy_like(like, value)


def copy_like(weight, values):
    """Tensor of an array, with the shape, device and memory layout of a weight."""
    return torch.empty_like(weight).copy_(torch.as_tensor(values))
