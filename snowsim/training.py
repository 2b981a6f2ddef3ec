"""What the trainings of both networks share: arithmetic, and weights and moments that are kept and taken over again."""

import torch


def arithmetic(device, precision):
    """Context in which networks compute in `precision`, `float32` or `bfloat16`; weights are float32 in both."""
    return torch.autocast(
        torch.device(device).type, torch.bfloat16, enabled=precision == "bfloat16"
    )


def load_weights(network, weights, name):
    """Copy weights (dict of arrays) into a network; ValueError, with `name`, where names or shapes differ."""
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    got = {key: tuple(value.shape) for key, value in weights.items()}
    for key in sorted(expected.keys() | got.keys()):
        if expected.get(key) != got.get(key):
            msg = f"{name}: expected {key} of shape {expected.get(key)}, got {got.get(key)}: other settings made it"
            raise ValueError(msg)
    network.load_state_dict({key: torch.as_tensor(value) for key, value in weights.items()})


def moments_of(optimiser):
    """What an optimiser keeps of each weight, by the weight's number; to be given to `load_moments`."""
    return optimiser.state_dict()["state"]


def load_moments(optimiser, moments, name):
    """Copy moments (by number of the weight, dicts of arrays) into an optimiser; none are there before the first step.

    ValueError, with `name`, if they are those of another number of weights.
    """
    parameters = [parameter for group in optimiser.param_groups for parameter in group["params"]]
    if len(moments) not in (0, len(parameters)):
        msg = f"{name}: expected moments of {len(parameters)} weights, got {len(moments)}: other settings made it"
        raise ValueError(msg)
    for index, values in moments.items():
        parameter = parameters[int(index)]
        # Laid out in memory as the weights are; a number of steps is a scalar.
        optimiser.state[parameter] = {
            key: (
                torch.empty_like(parameter)
                if value.ndim
                else torch.empty((), device=parameter.device)
            ).copy_(torch.as_tensor(value))
            for key, value in values.items()
        }


def on_cpu(state):
    """Nested dicts of tensors, brought to main memory where they are not there."""
    return {
        key: on_cpu(value) if isinstance(value, dict) else value.detach().cpu()
        for key, value in state.items()
    }
