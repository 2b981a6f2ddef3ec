"""One thread, as in every training."""

import torch

torch.set_num_threads(1)
