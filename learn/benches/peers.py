"""Trains networks of our sizes with PyTorch, and runs our graphs with onnxruntime; see peers.sh.

peers.py compare SPEED MODEL BATCHED ROUNDS
                                      interleaved rounds on one and two threads, then tables of medians and paired ratios;
                                      BATCHED is a folder for the graphs of batches of 64
peers.py torch THREADS                one line a stage: its name, milliseconds a step
peers.py onnxruntime MODEL            one line a graph: its name, microseconds a run, one thread
"""

import math
import os
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

STEPS = 30
RUNS = 301
BINS, UPRIGHT = 48, 4
HARMONICS, PAIRS_PER_HARMONIC, INVARIANT = 5, 2, 108
PAIRS = HARMONICS * PAIRS_PER_HARMONIC
LATENT = INVARIANT + 2 * PAIRS
CONDITIONING = 2 * HARMONICS + UPRIGHT
FEATURES, MEASUREMENT, COMPONENTS = 256, 32, 96
BATCH = 64
TRUNK_BATCH, GROUPS, VIEWS, CONTEXT, INSTANCES, OTHERS = 128, 48, 8, 7, 60, 256


def median_step(torch, modules, loss):
    """Milliseconds of a step with Adam: loss, gradient, update."""
    parameters = [p for module in modules for p in module.parameters()]
    optimizer = torch.optim.Adam(parameters, lr=1e-3, fused=True)
    times = []
    for _ in range(STEPS):
        started = time.perf_counter()
        optimizer.zero_grad()
        loss().backward()
        optimizer.step()
        times.append(time.perf_counter() - started)
    return 1e3 * statistics.median(times)


def trunk(torch):
    """Stage 1: cross-entropy of the azimuth over soft bins and the squared error of the rest."""
    nn = torch.nn
    layers, channels = [], 3
    for width in (24, 48, 96):
        layers += [nn.Conv2d(channels, width, 4, 2, 1), nn.ReLU()]
        channels = width
    network = nn.Sequential(
        *layers, nn.Flatten(), nn.Linear(96 * 16, FEATURES), nn.ReLU(), nn.Linear(FEATURES, MEASUREMENT),
        nn.Linear(MEASUREMENT, BINS + UPRIGHT),
    )
    network = network.to(memory_format=torch.channels_last)
    crops = torch.rand(2000, 3, 32, 32).to(memory_format=torch.channels_last)
    labels, rest = torch.softmax(torch.randn(2000, BINS), 1), torch.randn(2000, UPRIGHT)

    def loss():
        batch = torch.randint(2000, (TRUNK_BATCH,))
        answer = network(crops[batch] - 0.5)
        angle = -(torch.log_softmax(answer[:, :BINS], 1) * labels[batch]).sum(1).mean()
        return angle + 2 * (answer[:, BINS:] - rest[batch]).square().mean()

    return median_step(torch, [network], loss)


def autoencoder(torch):
    """Stage 2: the bound over several views of each instance, on the trunk's features."""
    nn = torch.nn

    def mlp(inputs, outputs, activation):
        hidden = [nn.Linear(inputs, 256), activation(), nn.Linear(256, 256)]
        return nn.Sequential(*hidden, activation(), nn.Linear(256, outputs))

    encoder = mlp(FEATURES + COMPONENTS + UPRIGHT, LATENT + INVARIANT + PAIRS, nn.ReLU)
    decoder = mlp(LATENT + CONDITIONING, MEASUREMENT + COMPONENTS, nn.SiLU)
    likelihood = nn.ParameterDict({
        "log_sigma": nn.Parameter(torch.zeros(MEASUREMENT + COMPONENTS)),
        "means": nn.Parameter(torch.zeros(INSTANCES, INVARIANT)),
    })
    rows = GROUPS * VIEWS
    seen = torch.randn(2000, FEATURES + COMPONENTS)
    wanted = torch.randn(2000, MEASUREMENT + COMPONENTS)
    told = torch.randn(2000, CONDITIONING)
    azimuth = torch.rand(2000) * 2 * math.pi
    harmonics = torch.arange(1, HARMONICS + 1).repeat_interleave(PAIRS_PER_HARMONIC)

    def turned(latents, angle):
        turn = angle[:, None] * harmonics
        cos, sin = turn.cos(), turn.sin()
        still, x, y = latents.split([INVARIANT, PAIRS, PAIRS], 1)
        return torch.cat([still, cos * x - sin * y, sin * x + cos * y], 1)

    def surprise(alone, variance, instances):
        """-E log P(beta | e), Eq. 13, bounded as ours is: a sample of the others' means stands for all."""
        others = torch.randint(INSTANCES, (OTHERS,))
        of_own, of_others = likelihood["means"][instances], likelihood["means"][others]
        sharpness = 1 / (variance + 1)
        apart = (alone - of_own).square()
        squares = (alone.square() * sharpness).sum(1, keepdim=True) - 2 * (alone * sharpness) @ of_others.T
        squares = squares + sharpness @ of_others.square().T
        same = instances[:, None] == others[None, :]
        rest = ((INSTANCES - 1) / (~same).sum(1, keepdim=True).clamp(min=1)).log()
        shares = torch.where(same, torch.full_like(squares, -1e4), rest - 0.5 * squares)
        shares = torch.cat([-0.5 * (apart * sharpness).sum(1, keepdim=True), shares], 1)
        log_sum = torch.logsumexp(shares, 1) - 0.5 * (variance + 1).log().sum(1)
        return 0.5 * (apart + variance).sum(1) + log_sum

    def loss():
        batch = torch.randint(2000, (rows,))
        instances = torch.randint(INSTANCES, (GROUPS,)).repeat_interleave(VIEWS)
        out = encoder(torch.cat([seen[batch], told[batch][:, :UPRIGHT]], 1))
        mean, log_variance = turned(out[:, :LATENT], azimuth[batch]), out[:, LATENT:].clamp(-8, 4)
        precision = (-log_variance).exp()
        free = torch.cat([precision, precision[:, INVARIANT:]], 1)
        encoded = (torch.arange(VIEWS) < 1 + torch.randint(CONTEXT, (GROUPS, 1))).float().reshape(rows, 1)
        informed = free * encoded
        variance = 1 / (informed.reshape(GROUPS, VIEWS, LATENT).sum(1) + 1)
        posterior = (informed * mean).reshape(GROUPS, VIEWS, LATENT).sum(1) * variance
        latent = posterior + variance.sqrt() * torch.randn_like(posterior)
        latents = turned(latent.repeat_interleave(VIEWS, 0), -azimuth[batch])
        residual = wanted[batch] - decoder(torch.cat([latents, told[batch]], 1))
        log_sigma = likelihood["log_sigma"]
        fit = (residual.square() * (-2 * log_sigma).exp() * 0.5 + log_sigma).sum(1).mean()
        divergence = 0.5 * (posterior.square() + variance - variance.log() - 1).sum() / rows
        own = 1 / (precision[:, :INVARIANT] + 1)
        alone = mean[:, :INVARIANT] * precision[:, :INVARIANT] * own
        return fit + divergence + surprise(alone, own, instances).mean()

    return median_step(torch, [encoder, decoder, likelihood], loss)


def run_torch(threads):
    import torch

    torch.set_num_threads(threads)
    torch.manual_seed(0)
    print(f"trunk {trunk(torch):.3f}")
    print(f"autoencoder {autoencoder(torch):.3f}")


def write_batched(model, folder):
    """All but the Jacobian, whose rows are those of one latent."""
    import onnx
    from onnx import numpy_helper

    folder.mkdir(parents=True, exist_ok=True)
    for graph in ("measurement", "encoder", "decoder", "image"):
        read = onnx.load(model / f"{graph}.onnx")
        for value in [*read.graph.input, *read.graph.output]:
            value.type.tensor_type.shape.dim[0].dim_value = BATCH
        shapes = {node.input[1] for node in read.graph.node if node.op_type == "Reshape"}
        # Zeros of a crop, beside which the encoder's mean has numbers of each crop.
        joined = {name for node in read.graph.node if node.op_type == "Concat" for name in node.input}
        for constant in read.graph.initializer:
            if constant.name in joined:
                rows = numpy_helper.to_array(constant).repeat(BATCH, axis=0)
                constant.CopyFrom(numpy_helper.from_array(rows, constant.name))
            if constant.name in shapes:
                shape = numpy_helper.to_array(constant).copy()
                shape[0] = BATCH
                constant.CopyFrom(numpy_helper.from_array(shape, constant.name))
        onnx.save(read, folder / f"{graph}.onnx")


def run_onnxruntime(model):
    import numpy as np
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    for graph in sorted(model.glob("*.onnx")):
        session = onnxruntime.InferenceSession(str(graph), options)
        draw = np.random.default_rng(0)
        inputs = {i.name: draw.random(i.shape, dtype=np.float32) for i in session.get_inputs()}
        # Bound once, so that no call converts anything.
        binding = session.io_binding()
        for name, value in inputs.items():
            binding.bind_cpu_input(name, value)
        for output in session.get_outputs():
            binding.bind_output(output.name)
        times = []
        for _ in range(RUNS):
            started = time.perf_counter()
            session.run_with_iobinding(binding)
            times.append(time.perf_counter() - started)
        print(f"{graph.stem} {1e6 * statistics.median(times):.2f}")


def lines(command, threads):
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    return {name: float(number) for name, number in (line.split() for line in out.splitlines())}


def compare(speed, model, batched, rounds):
    write_batched(model, batched)
    ours, peers, paired = defaultdict(list), defaultdict(list), defaultdict(list)
    for turn in range(rounds):
        for threads in (1, 2):
            # Whoever comes first changes from round to round.
            commands = [[speed, "train"], [sys.executable, __file__, "torch", str(threads)]]
            first, second = (lines(command, threads) for command in commands[:: 1 if turn % 2 == 0 else -1])
            mine, theirs = (first, second) if turn % 2 == 0 else (second, first)
            for stage, milliseconds in mine.items():
                ours[stage, threads].append(milliseconds)
                peers[stage, threads].append(theirs[stage])
        for batch, command, graphs in (
            (1, ["run", str(model)], model),
            (BATCH, ["run-batches", str(model), str(batched)], batched),
        ):
            mine = lines([speed, *command], 1)
            theirs = lines([sys.executable, __file__, "onnxruntime", str(graphs)], 1)
            for graph, microseconds in theirs.items():
                ours[f"{graph} | {batch}"].append(mine[graph])
                peers[f"{graph} | {batch}"].append(microseconds)
    for what, mine in ours.items():
        paired[what] = [a / b for a, b in zip(mine, peers[what])]

    def row(*names):
        what = names[0] if len(names) == 1 else names
        ratios = paired[what]
        print(
            f"| {' | '.join(map(str, names))} | {statistics.median(ours[what]):.1f} | {statistics.median(peers[what]):.1f} "
            f"| {statistics.median(ratios):.2f} [{min(ratios):.2f}..{max(ratios):.2f}] |"
        )

    print("| stage | threads | ours [ms a step] | PyTorch | ours / PyTorch, paired [min..max] |\n|---|---|---|---|---|")
    for what in (key for key in ours if isinstance(key, tuple)):
        row(*what)
    print("\n| graph | batch | tract [us] | onnxruntime | tract / onnxruntime, paired [min..max] |\n|---|---|---|---|---|")
    for what in (key for key in ours if isinstance(key, str)):
        row(what)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["torch", threads]:
            run_torch(int(threads))
        case ["onnxruntime", model]:
            run_onnxruntime(Path(model))
        case ["compare", speed, model, batched, rounds]:
            compare(speed, Path(model), Path(batched), int(rounds))
        case _:
            sys.exit(__doc__)
