"""Weights of networks and states of optimisers: checked when they are taken over, on the CPU when they are kept."""

import torch


def load_weights(network, weights, name):
    """Copy weights (dict of arrays) into a network; ValueError, with `name`, where names or shapes differ."""
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    got = {key: tuple(value.shape) for key, value in weights.items()}
    for key in sorted(expected.keys() | got.keys()):
        if expected.get(key) != got.get(key):
            msg = f"{name}: expected {key} of shape {expected.get(key)}, got {got.get(key)}: other settings made it"
            raise ValueError(msg)
    network.load_state_dict({key: torch.as_tensor(value) for key, value in weights.items()})


def on_cpu(state):
    """Nested dicts of tensors, brought to main memory where they are not there."""
    return {key: on_cpu(value) if isinstance(value, dict) else value.detach().cpu() for key, value in state.items()}
