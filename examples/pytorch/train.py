"""Trains a small viewpoint-dependent model with PyTorch and writes it as a model folder that `bench` can score.

    bench dataset scenes/tabletop.yaml --format webdataset --split train --seeds 40 --out data
    python examples/pytorch/train.py data/webdataset model
    bench models model
    bench scenes/tabletop.yaml --model model

Needs torch, onnx, numpy and pillow. The format is that of docs/models.md; the equations are the paper's.
"""

import argparse
import hashlib
import io
import json
import math
import tarfile
from pathlib import Path

import numpy as np
import torch
from PIL import Image
from torch import nn
from torch.nn import functional as F

HARMONICS = 5
CONDITIONING = 2 * HARMONICS + 4
LATENT = 64
MEASUREMENT = 32
CANARY_VIEWS = 2
CONTEXT = 4  # views that a latent is inferred from in training, at most
VIEWS = 8  # views of an instance in a step


def conditioning(viewpoint):
    """What the networks are told of a viewpoint (`conditioning: azimuth_harmonics`)."""
    x, y, z = viewpoint["direction"]
    azimuth = math.atan2(y, x)
    turns = [f(m * azimuth) for m in range(1, HARMONICS + 1) for f in (math.cos, math.sin)]
    roll = viewpoint["roll"]
    return [*turns, z, math.cos(roll), math.sin(roll), viewpoint["log_distance"]]


def load(folder):
    """Crops `[n, 3, 32, 32]` of 8 bits, conditionings `[n, 14]`, instance indices `[n]`, ids, and a hash of it all."""
    crops, told, instances, digest = [], [], [], hashlib.sha256()
    for shard in sorted(folder.glob("train-*.tar")):
        digest.update(shard.read_bytes())
        with tarfile.open(shard) as tar:
            picture = None
            for member in tar:
                content = tar.extractfile(member).read()
                if member.name.endswith(".masked.png"):
                    picture = np.asarray(Image.open(io.BytesIO(content)).convert("RGB"))
                elif member.name.endswith(".json"):
                    label = json.loads(content)
                    if label["viewpoint"] is not None:
                        crops.append(picture.transpose(2, 0, 1))
                        told.append(conditioning(label["viewpoint"]))
                        instances.append(label["instance"])
    ids, index = np.unique(instances, return_inverse=True)
    told = torch.tensor(told, dtype=torch.float32)
    return torch.from_numpy(np.stack(crops)), told, torch.from_numpy(index), ids.tolist(), digest.hexdigest()


class Measurement(nn.Module):
    """`m(z)`: convolutions, a linear layer, then a fixed whitening."""

    def __init__(self):
        super().__init__()
        layers, channels = [], 3
        for width in (24, 48, 96):
            layers += [nn.Conv2d(channels, width, 4, 2, 1), nn.ReLU()]
            channels = width
        self.trunk = nn.Sequential(*layers, nn.Flatten(), nn.Linear(96 * 4 * 4, 256), nn.ReLU())
        self.reduce = nn.Linear(256, MEASUREMENT)
        self.register_buffer("mean", torch.zeros(MEASUREMENT))
        self.register_buffer("whiten", torch.eye(MEASUREMENT))

    def features(self, crop):
        return self.trunk(crop - 0.5)

    def forward(self, crop):
        return (self.reduce(self.features(crop)) - self.mean) @ self.whiten


class Encoder(nn.Module):
    """`q(e | z, x)`: what one view says of the latent, as a Gaussian factor beside the prior."""

    def __init__(self, measurement):
        super().__init__()
        self.measurement = measurement
        self.layers = mlp(256 + CONDITIONING, 2 * LATENT, nn.ReLU)

    def forward(self, crop, conditioning):
        return self.of_features(self.measurement.features(crop), conditioning)

    def of_features(self, features, conditioning):
        out = self.layers(torch.cat([features, conditioning], 1))
        return out[:, :LATENT], out[:, LATENT:].clamp(-8, 4)


class Decoder(nn.Module):
    """`p(m | e, x)`. Smooth activations, since the estimator looks at derivatives."""

    def __init__(self):
        super().__init__()
        self.layers = mlp(LATENT + CONDITIONING, MEASUREMENT, nn.SiLU)

    def forward(self, latent, conditioning):
        return self.layers(torch.cat([latent, conditioning], 1))


class DecoderJacobian(nn.Module):
    """The decoder with its derivatives, row by row back through its layers: optional, but many times faster."""

    def __init__(self, decoder):
        super().__init__()
        self.decoder = decoder

    def forward(self, latent, conditioning):
        first, _, second, _, last = self.decoder.layers
        one = first(torch.cat([latent, conditioning], 1))
        two = second(F.silu(one))
        rows = (last.weight * silu_slope(two)) @ second.weight
        rows = (rows * silu_slope(one)) @ first.weight
        return last(F.silu(two)), rows[:, :LATENT], rows[:, LATENT:]


def silu_slope(x):
    gate = torch.sigmoid(x)
    return gate * (1 + x * (1 - gate))


def mlp(inputs, outputs, activation):
    return nn.Sequential(nn.Linear(inputs, 256), activation(), nn.Linear(256, 256), activation(), nn.Linear(256, outputs))


def descend(parameters, steps, loss, name):
    optimizer = torch.optim.Adam(parameters, lr=1e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps, 1e-5)
    for step in range(steps):
        value = loss()
        optimizer.zero_grad()
        value.backward()
        optimizer.step()
        schedule.step()
        if (step + 1) % max(steps // 5, 1) == 0:
            print(f"{name} {step + 1}/{steps}: {value.item():.4f}", flush=True)


def train_measurement(model, crops, told, steps):
    """`m(z)` is to tell the viewpoint: it is trained to, then whitened and frozen."""
    head = nn.Linear(MEASUREMENT, CONDITIONING)

    def loss():
        views = torch.randint(len(crops), (128,))
        m = model.reduce(model.features(crops[views].float() / 255))
        return F.mse_loss(head(m), told[views])

    descend([*model.parameters(), *head.parameters()], steps, loss, "measurement")
    with torch.no_grad():
        m = torch.cat([model(batch.float() / 255) for batch in crops.split(512)])
        values, vectors = torch.linalg.eigh(torch.cov(m.T))
        model.mean.copy_(m.mean(0))
        # A floor, or directions that hardly vary are blown up with their rounding errors.
        model.whiten.copy_(vectors / values.clamp(min=1e-3 * values.max().item()).sqrt())


def posterior(mean, log_variance, used):
    """Product of the prior `N(0, I)` and the factors of the `used` views: `[instances, views, latent]` to `[instances, latent]`."""
    information = used[..., None] * torch.exp(-log_variance)
    precision = 1 + information.sum(1)
    return (information * mean).sum(1) / precision, 1 / precision


def train_autoencoder(encoder, decoder, features, measured, told, by_instance, steps):
    """The bound of Eq. 12: a latent from some views of an instance predicts all of them."""
    log_sigma = nn.Parameter(torch.zeros(MEASUREMENT))

    def loss():
        chosen = torch.randint(len(by_instance), (48,)).tolist()
        views = torch.stack([by_instance[i][torch.randint(len(by_instance[i]), (VIEWS,))] for i in chosen])
        x = told[views]
        flat = lambda tensor: tensor.flatten(0, 1)
        mean, log_variance = encoder.of_features(flat(features[views]), flat(x))
        used = (torch.arange(VIEWS) < torch.randint(1, CONTEXT + 1, (len(chosen), 1))).float()
        shape = (len(chosen), VIEWS, LATENT)
        mean, variance = posterior(mean.view(shape), log_variance.view(shape), used)
        latent = mean + variance.sqrt() * torch.randn_like(mean)
        predicted = decoder(flat(latent[:, None].expand(shape)), flat(x))
        residual = (flat(measured[views]) - predicted) / log_sigma.exp()
        likelihood = -0.5 * residual.square().sum(1).view(len(chosen), VIEWS).sum(1) - VIEWS * log_sigma.sum()
        divergence = 0.5 * (mean.square() + variance - 1 - variance.log()).sum(1)
        return (divergence - likelihood).mean() / VIEWS

    descend([*encoder.layers.parameters(), *decoder.parameters(), log_sigma], steps, loss, "autoencoder")


@torch.no_grad()
def residuals(encoder, decoder, features, measured, told, by_instance):
    """`m(z) - m(e, x)` of instances that were not trained on: the latent from some views, the residuals of the others."""
    all_residuals = []
    for views in by_instance:
        views = views[torch.randperm(len(views))]
        known, others = views[:CONTEXT], views[CONTEXT : 8 * CONTEXT]
        mean, log_variance = encoder.of_features(features[known], told[known])
        latent, _ = posterior(mean[None], log_variance[None], torch.ones(1, len(known)))
        all_residuals.append(measured[others] - decoder(latent.expand(len(others), -1), told[others]))
    return torch.cat(all_residuals).double().numpy()


def student_t(residuals):
    """The most likely scale matrix and degrees of freedom of zero-mean residuals, by expectation maximisation."""
    n, d = residuals.shape
    best = None
    for degrees in (3.0, 5.0, 8.0, 12.0, 20.0, 50.0, 200.0):
        scale = residuals.T @ residuals / n
        for _ in range(30):
            distances = np.einsum("ni,ij,nj->n", residuals, np.linalg.inv(scale), residuals)
            weights = (degrees + d) / (degrees + distances)
            scale = (residuals * weights[:, None]).T @ residuals / n
        constant = math.lgamma((degrees + d) / 2) - math.lgamma(degrees / 2) - d / 2 * math.log(degrees * math.pi)
        likelihood = n * (constant - 0.5 * np.linalg.slogdet(scale)[1])
        likelihood -= (degrees + d) / 2 * np.log1p(distances / degrees).sum()
        if best is None or likelihood > best[0]:
            best = (likelihood, degrees, scale)
    _, degrees, scale = best
    upper = np.linalg.cholesky(np.linalg.inv(scale)).T
    return {"degrees_of_freedom": degrees, "sqrt_information": upper.tolist(), "residuals": n}


def export(folder, role, module, inputs, outputs):
    """Writes a graph, and returns its entry in the manifest and its cases of the canary."""
    module.eval()
    one = tuple(tensor[:1] for tensor in inputs.values())
    path = folder / f"{role}.onnx"
    # The exporter that needs no further package; `dynamo=True` with `external_data=False` does as well.
    torch.onnx.export(
        module, one, str(path), dynamo=False, opset_version=17, input_names=list(inputs), output_names=list(outputs)
    )
    cases = []
    for view in range(CANARY_VIEWS):
        row = tuple(tensor[view : view + 1] for tensor in inputs.values())
        with torch.no_grad():
            out = module(*row)
        out = out if isinstance(out, tuple) else (out,)
        flat = lambda tensors: [tensor.flatten().tolist() for tensor in tensors]
        cases.append({"role": role, "inputs": flat(row), "outputs": flat(out)})
    record = {
        **recorded(path),
        "inputs": {name: list(tensor.shape) for name, tensor in zip(inputs, one)},
        "outputs": {name: list(tensor.shape) for name, tensor in zip(outputs, out)},
    }
    return record, cases


def recorded(path):
    return {"file": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("data", type=Path, help="folder of train-*.tar, as bench dataset --format webdataset writes it")
    arguments.add_argument("out", type=Path, help="folder that gets the model")
    arguments.add_argument("--steps", type=int, default=4000, help="of each of the two stages")
    arguments.add_argument("--seed", type=int, default=0)
    options = arguments.parse_args()
    torch.manual_seed(options.seed)
    options.out.mkdir(parents=True, exist_ok=True)

    crops, told, index, ids, data_hash = load(options.data)
    by_instance = [torch.nonzero(index == i).flatten() for i in range(len(ids))]
    by_instance = [views for views in by_instance if len(views) >= 2 * CONTEXT]
    # One instance in ten is held out of the training, to calibrate the noise on.
    held_out, trained_on = by_instance[::10], [views for i, views in enumerate(by_instance) if i % 10]
    known = torch.cat(trained_on)
    print(f"{len(crops)} crops of {len(ids)} instances, {len(held_out)} held out")

    measurement, decoder = Measurement(), Decoder()
    encoder = Encoder(measurement)
    train_measurement(measurement, crops[known], told[known], options.steps)
    with torch.no_grad():
        batches = [batch.float() / 255 for batch in crops.split(512)]
        features = torch.cat([measurement.features(batch) for batch in batches])
        measured = torch.cat([measurement(batch) for batch in batches])
    train_autoencoder(encoder, decoder, features, measured, told, trained_on, options.steps)
    noise = student_t(residuals(encoder, decoder, features, measured, told, held_out))

    crop, x = crops[known[[0, -1]]].float() / 255, told[known[[0, -1]]]
    with torch.no_grad():
        latent, _ = encoder(crop, x)
    graphs, cases = {}, []
    for role, module, inputs, outputs in [
        ("encoder", encoder, {"crop": crop, "conditioning": x}, ["mean", "log_variance"]),
        ("measurement", measurement, {"crop": crop}, ["measurement"]),
        ("decoder", decoder, {"latent": latent, "conditioning": x}, ["measurement"]),
        (
            "decoder_jacobian",
            DecoderJacobian(decoder),
            {"latent": latent, "conditioning": x},
            ["measurement", "d_latent", "d_conditioning"],
        ),
    ]:
        graphs[role], own = export(options.out, role, module, inputs, outputs)
        cases += own
    canary, instances = options.out / "canary.json", options.out / "training_instances.txt"
    canary.write_text(json.dumps({"tolerance": 1e-4, "cases": cases}))
    instances.write_text("".join(f"{instance}\n" for instance in ids))
    manifest = {
        "format": "vantage model",
        "version": 2,
        "kind": "viewpoint_dependent",
        "latent": {"dimension": LATENT},
        "measurement": MEASUREMENT,
        "conditioning": "azimuth_harmonics",
        "graphs": graphs,
        "canary": recorded(canary),
        "training": {
            "origin": "examples/pytorch/train.py",
            "data_hash": data_hash,
            "instances": recorded(instances),
            "provenance": {"steps": str(options.steps), "seed": str(options.seed), "torch": torch.__version__},
        },
        "residual": noise,
    }
    # JSON is YAML.
    (options.out / "model.yaml").write_text(json.dumps(manifest, indent=1))
    print(f"model written to {options.out}, noise with {noise['degrees_of_freedom']} degrees of freedom")


if __name__ == "__main__":
    main()
