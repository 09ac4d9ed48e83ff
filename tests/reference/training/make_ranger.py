#!/usr/bin/env python3
"""Reference values for the optimiser, the schedule and the clipping of training/fovol-train.

    pip install torch==2.11.0 numpy safetensors
    python tests/reference/training/make_ranger.py [FILE]

Writes `training/fovol-train/tests/reference/optimise.safetensors`. Everything is computed in float64.

Ranger 20.4.11 is put together from what PyTorch has: `torch.optim.RAdam` with decoupled weight decay does the steps,
around it gradients are centralised before and Lookahead follows after. The formulas of
docs/guide/src/internals/algorithm.md, section 7.2, are computed beside it in NumPy; the script fails where the two
differ by more than rounding.

For the case `orthogonal` the steps of `wide.weight`, as a matrix of 3 rows, are those of `torch.optim.Muon` at twice the
learning rate, which computes in float64 here instead of bfloat16.

For the cases `with_gc`, `without_gc` and `orthogonal` the file has `CASE.NAME` [30, ...], float32, of parameters NAME after each of
30 steps with weight decay 1e-2. Parameters begin as, and the gradient of step t = 1, 2 ... is

    p_0[i] = 0.5 sin(1.3 i + n),    g_t[i] = 0.4 p[i] + sin(0.7 i + 1.9 t + n) (1 + 0.5 cos(t)) + 0.2

with i counting the numbers of a parameter and n the parameters from 0; the learning rate of step t is that of epoch
(t - 1) // 3 of a cosine from 0.05 to 1e-8 in 8 epochs, and stays there.

`cosine` [121] are the learning rates of `CosineAnnealingLR` from 1.25e-3 to 1e-8 in 120 epochs. `clip.norm` is the
length of the gradients of step 1 at p_0 together, and `clip.NAME` what `clip_grad_norm_` to 2.5 makes of them.
"""

import math
import sys
from pathlib import Path

import numpy as np
import torch
from safetensors.numpy import save_file

SHAPES = {"wide.weight": (3, 2, 3, 3), "wide.bias": (3,), "point.weight": (5, 4, 1, 1), "matrix": (4, 3), "one": (1,)}
STEPS = 30
BETAS, EPSILON, WEIGHT_DECAY = (0.95, 0.999), 1e-5, 1e-2
SLOW_STEPS, SLOW_SHARE, THRESHOLD = 6, 0.5, 5
ORTHOGONAL = 2.0
HERE = Path(__file__).resolve().parent
DEFAULT_FILE = HERE.parents[2] / "training/fovol-train/tests/reference/optimise.safetensors"


def initial():
    """The parameters before the first step."""
    counts = {name: np.arange(math.prod(shape)).reshape(shape) for name, shape in SHAPES.items()}
    return {name: 0.5 * np.sin(1.3 * i + n) for n, (name, i) in enumerate(counts.items())}


def gradient(n, parameter, t):
    """The gradient of parameter number n in step t."""
    i = np.arange(parameter.size).reshape(parameter.shape)
    return 0.4 * parameter + np.sin(0.7 * i + 1.9 * t + n) * (1 + 0.5 * math.cos(t)) + 0.2


def rate(t):
    """The learning rate of step t."""
    epoch = min((t - 1) // 3, 8)
    return 1e-8 + 0.5 * (0.05 - 1e-8) * (1 + math.cos(math.pi * epoch / 8))


def centralised(gradient):
    """Less its mean over all but the first dimension, where there are others."""
    return gradient - gradient.mean(axis=tuple(range(1, gradient.ndim)), keepdims=True) if gradient.ndim > 1 else gradient


def muon(parameter):
    """Muon for `parameter`, a matrix."""
    return torch.optim.Muon(
        [parameter], lr=1.0, weight_decay=WEIGHT_DECAY / ORTHOGONAL, momentum=BETAS[0], adjust_lr_fn="match_rms_adamw"
    )


def from_pytorch(has_centralisation, is_orthogonal):
    """The parameters after each step, by torch.optim.RAdam, and by Muon for the first if `is_orthogonal`."""
    start = list(initial().values())
    if is_orthogonal:
        start[0] = start[0].reshape(len(start[0]), -1)
    parameters = [torch.nn.Parameter(torch.from_numpy(p)) for p in start]
    slow = [p.detach().clone() for p in parameters]
    first = 1 if is_orthogonal else 0
    radam = torch.optim.RAdam(
        parameters[first:],
        betas=BETAS,
        eps=EPSILON,
        weight_decay=WEIGHT_DECAY,
        decoupled_weight_decay=True,
        foreach=False,
    )
    optimizers = {radam: 1.0} | ({muon(parameters[0]): ORTHOGONAL} if is_orthogonal else {})
    history = []
    for t in range(1, STEPS + 1):
        for n, parameter in enumerate(parameters):
            g = gradient(n, parameter.detach().numpy(), t)
            parameter.grad = torch.from_numpy(centralised(g) if has_centralisation else g)
        for optimizer, factor in optimizers.items():
            optimizer.param_groups[0]["lr"] = factor * rate(t)
            optimizer.step()
        if t % SLOW_STEPS == 0:
            with torch.no_grad():
                for parameter, s in zip(parameters, slow):
                    s += SLOW_SHARE * (parameter - s)
                    parameter.copy_(s)
        history.append([p.detach().numpy().copy() for p in parameters])
    return [np.stack(steps).reshape(-1, *shape) for steps, shape in zip(zip(*history), SHAPES.values())]


def orthogonal(direction):
    """Newton and Schulz's iterations of the matrix of `direction`, with steps as large as Adam's."""
    x = direction.reshape(len(direction), -1)
    x = x / np.linalg.norm(x)
    for _ in range(5):
        square = x @ x.T
        x = 3.4445 * x + (-4.7750 * square + 2.0315 * square @ square) @ x
    return (0.2 * math.sqrt(max(x.shape)) * x).reshape(direction.shape)


def from_formulas(has_centralisation, is_orthogonal):
    """The same by the formulas, a parameter after the other."""
    (beta1, beta2), limit = BETAS, 2 / (1 - BETAS[1]) - 1
    result = []
    for n, p in enumerate(initial().values()):
        m, v, slow, history = np.zeros_like(p), np.zeros_like(p), p.copy(), []
        for t in range(1, STEPS + 1):
            g = gradient(n, p, t)
            g = centralised(g) if has_centralisation else g
            v = beta2 * v + (1 - beta2) * g * g
            m = beta1 * m + (1 - beta1) * g
            rho = limit - 2 * t * beta2**t / (1 - beta2**t)
            p = p * (1 - WEIGHT_DECAY * rate(t))
            if is_orthogonal and p.shape[2:] == (3, 3):
                p = p - ORTHOGONAL * rate(t) * orthogonal((1 - beta1) * g + beta1 * m)
            elif rho > THRESHOLD:
                rectified = (rho - 4) / (limit - 4) * (rho - 2) / rho * limit / (limit - 2)
                s = math.sqrt((1 - beta2**t) * rectified) / (1 - beta1**t)
                p = p - s * rate(t) * m / (np.sqrt(v) + EPSILON)
            else:
                p = p - rate(t) / (1 - beta1**t) * m
            if t % SLOW_STEPS == 0:
                slow = slow + SLOW_SHARE * (p - slow)
                p = slow.copy()
            history.append(p)
        result.append(np.stack(history))
    return result


def ranger():
    """The cases of Ranger."""
    arrays = {}
    cases = {"with_gc": (True, False), "without_gc": (False, False), "orthogonal": (False, True)}
    for case, ways in cases.items():
        found, formulas = from_pytorch(*ways), from_formulas(*ways)
        worst = max(np.abs(a - b).max() for a, b in zip(found, formulas))
        print(f"{case}: PyTorch and the formulas differ by {worst:.1e}")
        assert worst < 1e-13
        arrays |= {f"{case}.{name}": p.astype(np.float32) for name, p in zip(SHAPES, found)}
    return arrays


def cosine():
    """The learning rates of 120 epochs."""
    optimizer = torch.optim.SGD([torch.zeros(1)], lr=1.25e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, T_max=120, eta_min=1e-8)
    rates = []
    for _ in range(121):
        rates.append(schedule.get_last_lr()[0])
        optimizer.step()
        schedule.step()
    return np.array(rates)


def clip():
    """Gradients before and after clipping."""
    parameters = [torch.nn.Parameter(torch.from_numpy(p)) for p in initial().values()]
    for n, parameter in enumerate(parameters):
        parameter.grad = torch.from_numpy(gradient(n, parameter.detach().numpy(), 1))
    norm = torch.nn.utils.clip_grad_norm_(parameters, 2.5)
    print(f"length of gradients: {norm:.3f}")
    clipped = {f"clip.{name}": parameter.grad.numpy() for name, parameter in zip(SHAPES, parameters)}
    return clipped | {"clip.norm": np.array([norm.item()])}


def main():
    # Muon rounds to bfloat16, for speed; these are values to compare with.
    torch.Tensor.bfloat16 = lambda tensor: tensor
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_FILE
    path.parent.mkdir(parents=True, exist_ok=True)
    save_file(ranger() | {"cosine": cosine()} | clip(), path)
    print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
