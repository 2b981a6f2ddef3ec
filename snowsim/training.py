"""What the trainings of both networks share.

Arithmetic, and weights and moments that are kept and taken over again.
"""

import warnings

import torch

# As torch names them: what x86-64 processors can do that lack AVX-512.
WITHOUT_AVX512 = ("DEFAULT", "NO AVX", "AVX", "AVX2")
IN_FLOAT32 = (
    "bfloat16 is ten times slower than float32 on a processor without AVX-512: computing in "
    "float32, which moves numbers as another processor does"
)


def arithmetic(device, precision):
    """Context in which networks compute in `precision`, `float32` or `bfloat16`.

    Weights are float32 in both. On a processor without AVX-512, which emulates bfloat16, `bfloat16`
    is float32, with a UserWarning.
    """
    kind = torch.device(device).type
    short = precision == "bfloat16"
    emulated = kind == "cpu" and torch.backends.cpu.get_cpu_capability() in WITHOUT_AVX512
    if short and emulated:
        warnings.warn(IN_FLOAT32, stacklevel=2)
    return torch.autocast(kind, torch.bfloat16, enabled=short and not emulated)


def load_weights(network, weights, name):
    """Copy weights (dict of arrays) into a network.

    ValueError, with `name`, where names or shapes differ.
    """
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    got = {key: tuple(value.shape) for key, value in weights.items()}
    for key in sorted(expected | got):
        if expected.get(key) != got.get(key):
            shapes = f"expected {key} of shape {expected.get(key)}, got {got.get(key)}"
            msg = f"{name}: {shapes}: other settings made it"
            raise ValueError(msg)
    network.load_state_dict({key: torch.as_tensor(value) for key, value in weights.items()})


def moments_of(optimiser):
    """What an optimiser keeps of each weight, by the weight's number.

    To be given to `load_moments`.
    """
    return optimiser.state_dict()["state"]


def load_moments(optimiser, moments):
    """Copy moments (by number of the weight, dicts of arrays) into an optimiser.

    None are there before the first step.
    """
    parameters = [parameter for group in optimiser.param_groups for parameter in group["params"]]
    for index, values in moments.items():
        parameter = parameters[int(index)]
        state = optimiser.state[parameter]
        for key, value in values.items():
            if value.ndim:
                # Laid out in memory as the weights are.
                state[key] = torch.empty_like(parameter)
            else:
                # A number of steps.
                state[key] = torch.empty((), device=parameter.device)
            state[key].copy_(torch.as_tensor(value))


def on_cpu(state):
    """Nested dicts of tensors, brought to main memory where they are not there."""
    if isinstance(state, dict):
        return {key: on_cpu(value) for key, value in state.items()}
    return state.detach().cpu()
