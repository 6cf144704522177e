"""Runs GTSAM on the graphs that our side writes, and compares; see peers.sh.

peers.py compare PEERS POSE_GRAPHS FOLDER ROUNDS
                                      interleaved rounds, then tables of medians and paired ratios
peers.py smooth GRAPH THRESHOLD SKIP EACH TIMES MAXIMUM
                                      iSAM2 on a graph that grows; EACH is 1 where all values are asked for after each step, else 0;
                                      writes seconds of each step and all values at the end; prints peak memory
peers.py cost GRAPH MAXIMUM...        the cost of the whole graph at each of the maxima of a file, by GTSAM's factors
peers.py batch POSE_GRAPH TOLERANCE   Levenberg-Marquardt on a graph in the g2o format
peers.py landmarks GRAPH MARGINALS    the largest difference of GTSAM's marginals from ours
"""

import os
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

import gtsam
import numpy as np
from gtsam import symbol

GAUGE, WEAK = 1e-3, 10.0
TOLERANCE = 1e-10
# Of ours, in whitened residuals: as `bench SCENE --online` has it, and a coarser one.
THRESHOLDS = ("0.002", "0.03")
# Of iSAM2, in coordinates, and steps between its checks: GTSAM's own values.
THRESHOLD, SKIP = "0.1", "10"


def peak_bytes():
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith("VmHWM")).split()[1])


def as_pose(numbers):
    x, y, z, qx, qy, qz, qw = numbers
    return gtsam.Pose3(gtsam.Rot3.Quaternion(qw, qx, qy, qz), np.array([x, y, z]))


def deviations(rotation, translation):
    return gtsam.noiseModel.Diagonal.Sigmas(np.array([rotation] * 3 + [translation] * 3))


class Ring:
    """The graph of examples/peers/ring.rs, read step by step."""

    def __init__(self, path):
        self.file = open(path, "rb")
        counts = self.take(5).astype(int)
        self.poses, self.detections, self.objects, self.latent, self.measurement = counts.tolist()
        self.odometry = deviations(*self.take(2))
        self.unit = gtsam.noiseModel.Unit.Create(self.measurement)
        self.seen = set()

    def take(self, count):
        return np.fromfile(self.file, dtype="<f8", count=count)

    def matrix(self, columns):
        return np.asfortranarray(self.take(self.measurement * columns).reshape(columns, -1).T)

    def step(self, number, before):
        """New factors and first values; `before` is the estimate of the pose before."""
        graph, first = gtsam.NonlinearFactorGraph(), gtsam.Values()
        motion, base = as_pose(self.take(7)), as_pose(self.take(7))
        robot = symbol("x", number)
        if number == 0:
            graph.add(gtsam.PriorFactorPose3(robot, base, gtsam.noiseModel.Isotropic.Sigma(6, GAUGE)))
            pose = base
        else:
            graph.add(gtsam.BetweenFactorPose3(symbol("x", number - 1), robot, motion, self.odometry))
            pose = before.compose(motion)
        first.insert(robot, pose)
        for _ in range(self.detections):
            which = int(self.take(1)[0])
            robot_from_object, object_base = as_pose(self.take(7)), as_pose(self.take(7))
            thing, latent = symbol("o", which), symbol("e", which)
            zero = np.zeros(self.latent)
            if which not in self.seen:
                self.seen.add(which)
                first.insert(thing, pose.compose(robot_from_object))
                first.insert(latent, zero)
                weak = gtsam.noiseModel.Isotropic.Sigma(6, WEAK)
                graph.add(gtsam.PriorFactorPose3(thing, object_base, weak))
                graph.add(gtsam.PriorFactorVector(latent, zero, gtsam.noiseModel.Unit.Create(self.latent)))
            blocks = [self.matrix(6), self.matrix(6), self.matrix(self.latent)]
            constant = self.take(self.measurement)
            linear = gtsam.JacobianFactor(
                robot, blocks[0], thing, blocks[1], latent, blocks[2], -constant, self.unit
            )
            about = gtsam.Values()
            about.insert(robot, base)
            about.insert(thing, object_base)
            about.insert(latent, zero)
            graph.add(gtsam.LinearContainerFactor(linear, about))
        return graph, first

    def numbers(self, values):
        """As our side writes them."""
        names = [symbol("x", i) for i in range(self.poses)] + [symbol("o", i) for i in range(self.objects)]
        rows = []
        for name in names:
            pose = values.atPose3(name)
            quaternion = pose.rotation().toQuaternion()
            rows += [*pose.translation(), quaternion.x(), quaternion.y(), quaternion.z(), quaternion.w()]
        for i in range(self.objects):
            rows += [*values.atVector(symbol("e", i))]
        return np.array(rows)

    def values(self, numbers):
        values, poses = gtsam.Values(), self.poses + self.objects
        for i, row in enumerate(numbers[: 7 * poses].reshape(poses, 7)):
            name = symbol("x", i) if i < self.poses else symbol("o", i - self.poses)
            values.insert(name, as_pose(row))
        for i, row in enumerate(numbers[7 * poses :].reshape(self.objects, self.latent)):
            values.insert(symbol("e", i), row)
        return values


def smooth(path, threshold, skip, each, times, maximum):
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(threshold)
    parameters.relinearizeSkip = skip
    isam, ring, seconds, pose = gtsam.ISAM2(parameters), Ring(path), [], None
    held = peak_bytes()
    for number in range(ring.poses):
        graph, first = ring.step(number, pose)
        cpu, wall = time.process_time(), time.perf_counter()
        isam.update(graph, first)
        if each:
            isam.calculateEstimate()
        else:
            isam.calculateEstimatePose3(symbol("x", number))
        seconds.append([time.process_time() - cpu, time.perf_counter() - wall])
        pose = isam.calculateEstimatePose3(symbol("x", number))
    print(f"memory {peak_bytes() - held}")
    np.array(seconds).astype("<f8").tofile(times)
    ring.numbers(isam.calculateEstimate()).astype("<f8").tofile(maximum)


def cost(path, files):
    ring, whole = Ring(path), gtsam.NonlinearFactorGraph()
    for number in range(ring.poses):
        whole.push_back(ring.step(number, gtsam.Pose3())[0])
    size = 7 * (ring.poses + ring.objects) + ring.latent * ring.objects
    for file in files:
        for i, numbers in enumerate(np.fromfile(file, dtype="<f8").reshape(-1, size)):
            print(f"{Path(file).name}.{i} {whole.error(ring.values(numbers))!r}")


def batch(path, tolerance):
    graph, start = gtsam.readG2o(path, True)
    graph.add(gtsam.PriorFactorPose3(0, start.atPose3(0), gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)))
    parameters = gtsam.LevenbergMarquardtParams()
    if tolerance > 0:
        parameters.setRelativeErrorTol(tolerance)
        parameters.setAbsoluteErrorTol(tolerance)
    cpu, wall = time.process_time(), time.perf_counter()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, start, parameters)
    values = optimizer.optimize()
    print(f"cpu {time.process_time() - cpu}\nwall {time.perf_counter() - wall}")
    print(f"cost {graph.error(values)!r}\niterations {optimizer.iterations()}")


def landmarks(path, marginals):
    numbers = iter(np.fromfile(path, dtype="<f8"))

    def take(count):
        return np.array([next(numbers) for _ in range(count)])

    poses, points, sightings = take(3).astype(int).tolist()
    gauge, rotation, translation, pixels = take(4)
    camera, mount = gtsam.Cal3_S2(*take(2), 0.0, *take(2)), as_pose(take(7))
    graph, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for i in range(poses):
        start.insert(symbol("x", i), as_pose(take(7)))
    for i in range(points):
        start.insert(symbol("l", i), take(3))
    first = symbol("x", 0)
    graph.add(
        gtsam.PriorFactorPose3(first, start.atPose3(first), gtsam.noiseModel.Isotropic.Sigma(6, gauge))
    )
    for i in range(poses - 1):
        names = symbol("x", i), symbol("x", i + 1)
        graph.add(gtsam.BetweenFactorPose3(*names, as_pose(take(7)), deviations(rotation, translation)))
    noise = gtsam.noiseModel.Isotropic.Sigma(2, pixels)
    for _ in range(sightings):
        pose, point, u, v = take(4)
        names = symbol("x", int(pose)), symbol("l", int(point))
        graph.add(gtsam.GenericProjectionFactorCal3_S2(np.array([u, v]), noise, *names, camera, mount))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(0)
    parameters.setAbsoluteErrorTol(1e-13)
    values = gtsam.LevenbergMarquardtOptimizer(graph, start, parameters).optimize()
    # Gauss-Newton from there: the maximum to rounding.
    for _ in range(5):
        values = values.retract(graph.linearize(values).optimize())
    print(f"cost {graph.error(values)!r}\nsightings {sightings}")
    theirs = gtsam.Marginals(graph, values)
    names = [symbol("x", i) for i in range(poses)] + [symbol("l", i) for i in range(points)]
    ours = iter(np.fromfile(marginals, dtype="<f8"))
    for which in ("whole", "tree"):
        largest = defaultdict(float)
        for i, name in enumerate(names):
            expected = theirs.marginalCovariance(name)
            got = np.array([next(ours) for _ in range(expected.size)]).reshape(expected.shape)
            # Of each entry, over the product of its two deviations.
            roots = np.sqrt(np.diag(expected))
            kind = "poses" if i < poses else "landmarks"
            largest[kind] = max(largest[kind], np.abs((got - expected) / np.outer(roots, roots)).max())
        for kind, difference in largest.items():
            print(f"{which}-{kind} {difference}")


def lines(command):
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(list(map(str, command)), env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return {name: float(number) for name, number in (line.split() for line in done.stdout.splitlines())}


def of(numbers, digits=2):
    middle = statistics.median(numbers)
    return f"{middle:.{digits}f} [{min(numbers):.{digits}f}..{max(numbers):.{digits}f}]"


def alternate(turn, ours, theirs):
    """Runs both; who comes first changes from round to round."""
    if turn % 2 == 0:
        return ours(), theirs()
    second = theirs()
    return ours(), second


def compare_incremental(peers, folder, rounds):
    python = [sys.executable, __file__]
    print("| latent | ours, threshold | | ours | iSAM2 | ours / iSAM2, paired [min..max] |\n|---|---|---|---|---|---|")
    told = []
    for latent in (68, 128):
        graph = folder / f"ring-{latent}"
        lines([peers, "ring", latent, graph])
        found, maxima = defaultdict(list), {}
        for turn in range(rounds):
            for name, command in commands(peers, python, graph)[:: 1 if turn % 2 == 0 else -1]:
                times, maxima[name] = folder / "times", folder / f"maximum-{latent}-{name}"
                answer = lines([*command, times, maxima[name]])
                steps = 1e3 * np.fromfile(times, dtype="<f8").reshape(-1, 2)[:, 0]
                for what, share in (("p50", 0.5), ("p95", 0.95), ("max", 1.0)):
                    found[name, f"{what} of a step, CPU ms"].append(np.quantile(steps, share))
                found[name, "all steps, CPU s"].append(steps.sum() / 1e3)
                found[name, "peak memory, MB"].append(answer["memory"] / 1e6)
        for threshold in THRESHOLDS:
            for name, what in found:
                if name == threshold:
                    ours, theirs = found[threshold, what], found["iSAM2", what]
                    ratios = of([a / b for a, b in zip(ours, theirs)], 3)
                    middle = [statistics.median(side) for side in (ours, theirs)]
                    print(f"| {latent} | {threshold} | {what} | {middle[0]:.2f} | {middle[1]:.2f} | {ratios} |")
        costs = lines([*python, "cost", graph, *maxima.values()])
        least = min(costs.values())
        told.extend((latent, name, number / least - 1, number) for name, number in costs.items())
    print("\n| latent | values | cost | over the least |\n|---|---|---|---|")
    for latent, name, excess, cost in told:
        print(f"| {latent} | {name} | {cost:.4f} | {excess:.2e} |")


def commands(peers, python, graph):
    """Ours at each threshold, and theirs."""
    ours = [(threshold, [peers, "smooth", graph, threshold]) for threshold in THRESHOLDS]
    return [*ours, ("iSAM2", [*python, "smooth", graph, THRESHOLD, SKIP, 1])]


def compare_batch(peers, pose_graphs, rounds):
    print("\n| pose graph | stops at | ours, CPU ms | GTSAM | GTSAM / ours, paired [min..max] | optimum / GTSAM's - 1 |")
    print("|---|---|---|---|---|---|")
    for graph in sorted(pose_graphs.glob("*.g2o")):
        for name, tolerance in ((f"{TOLERANCE:g}", TOLERANCE), ("GTSAM's own", 0)):
            ours, theirs = [], []
            for turn in range(rounds):
                mine, other = alternate(
                    turn,
                    lambda: lines([peers, "batch", graph]),
                    lambda: lines([sys.executable, __file__, "batch", graph, tolerance]),
                )
                ours.append(mine)
                theirs.append(other)
            ratios = [b["cpu"] / a["cpu"] for a, b in zip(ours, theirs)]
            middle = [1e3 * statistics.median(run["cpu"] for run in runs) for runs in (ours, theirs)]
            counts = [int(runs[0]["iterations"]) for runs in (ours, theirs)]
            apart = ours[0]["cost"] / theirs[0]["cost"] - 1
            print(
                f"| {graph.stem} | {name} | {middle[0]:.2f} ({counts[0]} iterations) | {middle[1]:.2f} ({counts[1]}) "
                f"| {of(ratios)} | {apart:.1e} |"
            )


def compare_marginals(peers, folder):
    graph, marginals = folder / "landmarks", folder / "marginals"
    ours = lines([peers, "landmarks", graph, marginals])
    theirs = lines([sys.executable, __file__, "landmarks", graph, marginals])
    print(f"\ncost: ours {ours['cost']!r}, the tree's {ours['tree']!r}, GTSAM's {theirs['cost']!r}\n")
    print("| marginals | of the whole problem | of the tree |\n|---|---|---|")
    for kind in ("poses", "landmarks"):
        print(f"| {kind} | {theirs[f'whole-{kind}']:.1e} | {theirs[f'tree-{kind}']:.1e} |")


def compare(peers, pose_graphs, folder, rounds):
    compare_incremental(peers, folder, rounds)
    compare_batch(peers, pose_graphs, rounds)
    compare_marginals(peers, folder)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["smooth", graph, threshold, skip, each, times, maximum]:
            smooth(graph, float(threshold), int(skip), each == "1", times, maximum)
        case ["cost", graph, *files]:
            cost(graph, files)
        case ["batch", graph, tolerance]:
            batch(graph, float(tolerance))
        case ["landmarks", graph, marginals]:
            landmarks(graph, marginals)
        case ["compare", peers, pose_graphs, folder, rounds]:
            compare(peers, Path(pose_graphs), Path(folder), int(rounds))
        case _:
            sys.exit(__doc__)
