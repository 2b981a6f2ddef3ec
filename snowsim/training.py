"""Parts that the trainings of both networks share: precision, and states to keep and restore."""

import warnings

import torch

# Names that torch gives to the capability of x86-64 processors without AVX-512.
WITHOUT_AVX512 = ("DEFAULT", "NO AVX", "AVX", "AVX2")
IN_FLOAT32 = (
    "bfloat16 is ten times slower than float32 on a processor without AVX-512: computing in "
    "float32, which moves numbers as another processor does"
)


def arithmetic(device, precision):
    """Context in which networks compute in `precision`, `float32` or `bfloat16`.

    Weights are always float32. A processor without AVX-512 would emulate bfloat16: there networks
    compute in float32, with a UserWarning.
    """
    kind = torch.device(device).type
    is_bfloat16 = precision == "bfloat16"
    is_emulated = kind == "cpu" and torch.backends.cpu.get_cpu_capability() in WITHOUT_AVX512
    if is_bfloat16 and is_emulated:
        warnings.warn(IN_FLOAT32, stacklevel=2)
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


def moments_of(optimiser):
    """Moments of an optimiser, dicts of tensors by number of the weight, for `load_moments`."""
    return optimiser.state_dict()["state"]


def load_moments(optimiser, moments):
    """Copy moments, dicts of arrays by number of the weight, into an optimiser.

    Before the first step there are none.
    """
    parameters = [parameter for group in optimiser.param_groups for parameter in group["params"]]
    for index, values in moments.items():
        parameter = parameters[int(index)]
        state = optimiser.state[parameter]
        for key, value in values.items():
            if value.ndim:
                # Moments are laid out in memory as the weights are.
                state[key] = torch.empty_like(parameter)
            else:
                # The number of steps is a scalar.
                state[key] = torch.empty((), device=parameter.device)
            state[key].copy_(torch.as_tensor(value))


def on_cpu(state):
    """Nested dicts of tensors, moved to main memory."""
    if isinstance(state, dict):
        return {key: on_cpu(value) for key, value in state.items()}
    return state.detach().cpu()
