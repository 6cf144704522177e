"""Computes scores anew from what `bench SCENE --dump` leaves, and compares them with those of `results.json`.

    bench sparse_loop --seeds 4 --dump --out out
    python examples/recompute/recompute.py out/scenes/sparse_loop

Scores of clusters and silhouettes are scikit-learn's, of the clusters in the files; how far scikit-learn's own clusters agree with these is
told, too. NEES, trajectories and neighbours are NumPy's and SciPy's. Nothing of Vantage is used.
Exits with 1 where a score differs by more than 1e-6, relative to it above 1, or a file that it is made of is missing. Scores of the
compared tables that it does not know are named. Needs numpy, scipy and scikit-learn.
"""

import argparse
import csv
import json
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from sklearn import metrics
from sklearn.cluster import HDBSCAN, AgglomerativeClustering
from sklearn.metrics.cluster import contingency_matrix, pair_confusion_matrix

TOLERANCE = 1e-6
UP = np.array([0.0, 0.0, 1.0])


def rms(errors):
    return float(np.sqrt(np.mean(np.square(errors))))


def rotation_vector(matrices):
    return Rotation.from_matrix(matrices).as_rotvec()


def se3_log(poses):
    """Rotation first, then translation, of poses `[n, 4, 4]`: the logarithm of the group, not of its parts."""
    tangents = []
    for pose, omega in zip(poses, rotation_vector(poses[:, :3, :3])):
        angle = np.linalg.norm(omega)
        hat = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]])
        if angle < 1e-6:
            inverse = np.eye(3) - hat / 2 + hat @ hat / 12
        else:
            weight = (1 - angle * np.sin(angle) / (2 * (1 - np.cos(angle)))) / angle**2
            inverse = np.eye(3) - hat / 2 + weight * hat @ hat
        tangents.append(np.concatenate([omega, inverse @ pose[:3, 3]]))
    return np.array(tangents)


def trajectory(truth, answer):
    true, own = truth["world_from_robot"], answer["world_from_robot"]
    true_first, own_first = np.linalg.inv(true[0]) @ true, np.linalg.inv(own[0]) @ own
    found = {"ate": rms(np.linalg.norm(true_first[:, :3, 3] - own_first[:, :3, 3], axis=1))}

    p, q = own[:, :3, 3], true[:, :3, 3]
    p0, q0 = p - p.mean(0), q - q.mean(0)
    u, _, vt = np.linalg.svd(q0.T @ p0)
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    found["ate_umeyama"] = rms(np.linalg.norm(q0 - p0 @ turn.T, axis=1))

    true_steps = np.linalg.inv(true[:-1]) @ true[1:]
    own_steps = np.linalg.inv(own[:-1]) @ own[1:]
    left = np.linalg.inv(true_steps) @ own_steps
    found["rpe_translation"] = rms(np.linalg.norm(left[:, :3, 3], axis=1))
    found["rpe_rotation"] = rms(np.linalg.norm(rotation_vector(left[:, :3, :3]), axis=1))

    ahead = [true[0, :3, :3] @ poses[:, :3, 0].T for poses in (true_first, own_first)]
    yaw_true, yaw_own = [np.arctan2(a[1], a[0]) for a in ahead]
    found["heading"] = rms((yaw_own - yaw_true + np.pi) % (2 * np.pi) - np.pi)

    if "object_center" in answer:
        placed = ~np.isnan(answer["object_center"][:, 0])
        centers = answer["object_center"][placed] @ np.linalg.inv(own[0])[:3, :3].T + np.linalg.inv(own[0])[:3, 3]
        true_centers = (np.linalg.inv(true[0]) @ truth["world_from_object"])[placed][:, :3, 3]
        found["object_center"] = rms(np.linalg.norm(centers - true_centers, axis=1))
    return found


def online(truth, newest):
    """Of the newest pose after each step."""
    errors = trajectory(truth, newest)
    found = {"newest_position": errors["ate"], "newest_heading": errors["heading"]}
    promised = consistency(truth, newest)
    return found | ({"nees_newest": promised["nees_pose"]} if promised else {})


def nees(errors, covariances):
    """NEES over the number of numbers."""
    solved = np.linalg.solve(covariances, errors[..., None])[..., 0]
    return np.sum(errors * solved, axis=-1) / errors.shape[-1]


def surprise(errors, covariances):
    return 0.5 * (errors.shape[-1] * nees(errors, covariances) + np.linalg.slogdet(2 * np.pi * covariances)[1])


def inside(name, per_number, numbers):
    found = chi2.cdf(numbers * np.asarray(per_number), numbers)
    return {f"{name}_inside{round(100 * share)}": np.mean(found <= share) for share in (0.5, 0.8, 0.95)}


def consistency(truth, answer):
    if "pose_covariance" not in answer:
        return {}
    true, own = truth["world_from_robot"], answer["world_from_robot"]
    true_first, own_first = np.linalg.inv(true[0]) @ true, np.linalg.inv(own[0]) @ own
    covariances = answer["pose_covariance"][1:]
    xi = se3_log(np.linalg.inv(own_first[1:]) @ true_first[1:])
    up = np.einsum("nji,j->ni", own_first[1:, :3, :3], true[0, :3, :3].T @ UP)
    about = np.einsum("ni,nij,nj->n", up, covariances[:, :3, :3], up)[:, None, None]
    turned = np.sum(up * xi[:, :3], axis=1)[:, None]
    found = {}
    for name, errors, own_covariances in (
        ("position", xi[:, 3:], covariances[:, 3:, 3:]),
        ("heading", turned, about),
        ("pose", xi, covariances),
    ):
        per_number, of_steps = nees(errors, own_covariances), surprise(errors, own_covariances)
        found |= {f"nees_{name}_end": per_number[-1], f"nees_{name}": per_number.mean()}
        found |= {f"{name}_surprise_end": of_steps[-1], f"{name}_surprise": of_steps.mean()}
        found |= inside(name, per_number, errors.shape[1])

    if "object_center_covariance" in answer:
        own_from_true = own[0] @ np.linalg.inv(true[0])
        objects = own_from_true @ truth["world_from_object"]
        placed = ~np.isnan(answer["object_center"][:, 0])
        off, of_centers = objects[placed, :3, 3] - answer["object_center"][placed], answer["object_center_covariance"][placed]
        found["nees_object_center"] = np.mean(nees(off, of_centers))
        found["object_center_surprise"] = np.mean(surprise(off, of_centers))
        found |= inside("object_center", nees(off, of_centers), 3)
        yaws, variances = [], []
        for i in np.flatnonzero(placed & (truth["object_symmetry"] == 1)):
            if "object_rotation" not in answer or np.isnan(answer["object_rotation"][i, 0, 0]):
                continue
            turn = answer["object_rotation"][i]
            axis = turn.T @ own_from_true[:3, :3] @ UP
            variance = axis @ answer["object_rotation_covariance"][i] @ axis
            if variance < np.pi**2 / 3:
                yaws.append([axis @ rotation_vector(turn.T @ objects[i, :3, :3])])
                variances.append([[variance]])
        if yaws:
            yaws, variances = np.array(yaws), np.array(variances)
            found["nees_object_yaw"] = np.mean(nees(yaws, variances))
            found["object_yaw_surprise"] = np.mean(surprise(yaws, variances))
            found |= inside("object_yaw", nees(yaws, variances), 1)
    return found


def clusters(instances, labels):
    homogeneity, completeness, v = metrics.homogeneity_completeness_v_measure(instances, labels)
    return {
        "ari": metrics.adjusted_rand_score(instances, labels),
        "nmi": metrics.normalized_mutual_info_score(instances, labels),
        "v_measure": v,
        "homogeneity": homogeneity,
        "completeness": completeness,
        "purity": contingency_matrix(instances, labels).max(axis=0).sum() / len(labels),
    }


def recall(k, distances, instances, sessions=None):
    """A wrong one at the same distance comes before the right one."""
    same = instances[:, None] == instances[None]
    right = same & ~np.eye(len(instances), dtype=bool)
    if sessions is not None:
        right &= sessions[:, None] != sessions[None]
    asked = right.any(axis=1)
    best = np.where(right, distances, np.inf).min(axis=1)
    before = ((distances <= best[:, None]) & ~same).sum(axis=1)
    return np.mean(before[asked] < k)


def embeddings(of):
    instances, sessions, numbers = of["instance"], of["session"], of["embedding"].astype(float)
    distances = metrics.pairwise_distances(numbers)
    found = clusters(instances, of["ward"]) if "ward" in of else {}
    found["silhouette"] = metrics.silhouette_score(distances, instances, metric="precomputed")
    for k in (1, 5):
        found[f"recall_at{k}"] = recall(k, distances, instances)
        found[f"recall_at{k}_across_light"] = recall(k, distances, instances, sessions)

    names, known = np.unique(instances), sessions % 2 == 0
    means = np.array([numbers[known & (instances == name)].mean(axis=0) for name in names])
    # The means are kept in single precision.
    means = means.astype(np.float32).astype(float)
    index = np.searchsorted(names, instances)
    freedom = (known.sum() - len(names)) * numbers.shape[1]
    variance = np.sum((numbers[known] - means[index[known]]) ** 2) / freedom
    asked = ~known
    squared = ((numbers[asked, None] - means[None]) ** 2).sum(axis=-1)
    weights = np.exp(-(squared - squared.min(axis=1, keepdims=True)) / (2 * variance))
    own = np.arange(asked.sum()), index[asked]
    found["instance_probability"] = np.mean(weights[own] / weights.sum(axis=1))
    others = squared.copy()
    others[own] = np.inf
    found["instance_right"] = np.mean(squared[own] < others.min(axis=1))
    return found


def density(of):
    if "hdbscan" not in of:
        return {}
    labels, instances = of["hdbscan"].copy(), of["instance"]
    noise = labels < 0
    found = labels.max() + 1
    # Each piece of noise is a cluster of its own.
    labels[noise] = found + np.arange(noise.sum())
    right = len(np.unique(instances))
    return clusters(instances, labels) | {"noise": noise.mean(), "cluster_count": abs(found - right) / right}


def association(truth, file):
    """Of pairs of detections that show an object; one that is told to be of nothing is alone."""
    shown = truth["detection_object"]
    with open(file) as rows:
        told = np.array([int(row["object"]) if row["object"] else -1 for row in csv.DictReader(rows)])
    told[told < 0] = told.max() + 1 + np.arange((told < 0).sum())
    right, told = shown[shown >= 0], told[shown >= 0]
    (_, false), (missed, both) = pair_confusion_matrix(right, told)
    return {
        "pair_precision": both / (both + false) if both + false else None,
        "pair_recall": both / (both + missed) if both + missed else None,
        "pair_f1": 2 * both / (2 * both + false + missed) if both + false + missed else None,
        "ari": metrics.adjusted_rand_score(right, told),
    }


def class_recall(beliefs, seed):
    """Of objects whose class earlier seeds hold: whether the nearest of those is of it."""
    latents, families = beliefs[seed]
    earlier = [beliefs[other] for other in sorted(beliefs) if other < seed]
    if not earlier:
        return None
    gallery, classes = np.concatenate([e[0] for e in earlier]), np.concatenate([e[1] for e in earlier])
    hits = []
    for latent, family in zip(latents, families):
        distances, same = ((gallery - latent) ** 2).sum(axis=1), classes == family
        if same.any():
            hits.append(distances[same].min() < distances[~same].min(initial=np.inf))
    return np.mean(hits) if hits else None


class Comparison:
    """Counts the scores that were computed anew, and how far they are off."""

    def __init__(self):
        self.count, self.worst, self.wrong = defaultdict(int), defaultdict(float), []
        self.unknown = set()

    def missing(self, table, run, file):
        if run["scores"]:
            self.wrong.append(f"{table}, {run['method']}, seed {run['seed']}: has scores, but there is no {file}")

    def compare(self, table, run, found):
        self.unknown |= {(table, metric) for metric in run["scores"] if metric not in found}
        for metric, theirs in found.items():
            ours = run["scores"].get(metric)
            if ours is None or theirs is None:
                continue
            off = abs(ours - theirs) / max(1.0, abs(ours))
            self.count[table, metric] += 1
            self.worst[table, metric] = max(off, self.worst[table, metric])
            if not off <= TOLERANCE:
                self.wrong.append(f"{table}, {run['method']}, seed {run['seed']}: {metric} is {ours}, computed anew {theirs}")


def agreement(of):
    """How alike scikit-learn's own clusters of the same embeddings are, by the adjusted Rand index."""
    numbers = of["embedding"].astype(float)
    alike = {}
    if "ward" in of:
        ward = AgglomerativeClustering(len(np.unique(of["ward"])), linkage="ward").fit_predict(numbers)
        alike["ward"] = metrics.adjusted_rand_score(of["ward"], ward)
    if "hdbscan" in of:
        found = HDBSCAN(min_cluster_size=5, min_samples=5, copy=True).fit_predict(numbers)
        alike["hdbscan"] = metrics.adjusted_rand_score(of["hdbscan"], found)
    return alike


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="a result folder of a run with --dump")
    results = parser.parse_args().results
    tables = {table["name"]: table for table in json.loads((results / "results.json").read_text())["tables"]}

    def load(name):
        path = results / name
        return dict(np.load(path)) if path.exists() else None

    comparison, alike = Comparison(), defaultdict(list)
    for name, scores in (("trajectory", trajectory), ("consistency", consistency), ("coverage", consistency)):
        for run in tables.get(name, {"runs": []})["runs"]:
            truth, answer = load(f"{run['seed']}/truth.npz"), load(f"{run['seed']}/{run['method']}.npz")
            if truth is not None and answer is not None:
                comparison.compare(name, run, scores(truth, answer))
            else:
                comparison.missing(name, run, f"{run['seed']}/{run['method']}.npz")
    for run in tables.get("online", {"runs": []})["runs"]:
        truth, newest = load(f"{run['seed']}/truth.npz"), load(f"{run['seed']}/{run['method']}.online.npz")
        if truth is not None and newest is not None:
            comparison.compare("online", run, online(truth, newest))
        else:
            comparison.missing("online", run, f"{run['seed']}/{run['method']}.online.npz")
    for name, scores in (("latents", embeddings), ("instances", embeddings), ("density", density)):
        for run in tables.get(name, {"runs": []})["runs"]:
            of = load(f"{run['seed']}/{run['method']}.latents.npz")
            if of is None:
                comparison.missing(name, run, f"{run['seed']}/{run['method']}.latents.npz")
                continue
            comparison.compare(name, run, scores(of))
            if name == "density":
                for kind, ari in agreement(of).items():
                    alike[kind].append(ari)
    for run in tables.get("association", {"runs": []})["runs"]:
        truth, file = load(f"{run['seed']}/truth.npz"), results / f"{run['seed']}/{run['method']}.association.csv"
        if truth is not None and file.exists():
            comparison.compare("association", run, association(truth, file))

    semantics = tables.get("semantics", {"runs": []})["runs"]
    beliefs = defaultdict(dict)
    for run in semantics:
        truth, answer = load(f"{run['seed']}/truth.npz"), load(f"{run['seed']}/{run['method']}.npz")
        if answer is not None and "object_latent_steady" in answer:
            # Latents are compared in single precision.
            latents = answer["object_latent_steady"].astype(np.float32).astype(float)
            known = ~np.isnan(latents[:, 0])
            beliefs[run["method"]][run["seed"]] = latents[known], truth["object_family"][known]
    for run in semantics:
        if run["seed"] in beliefs[run["method"]]:
            found = class_recall(beliefs[run["method"]], run["seed"])
            comparison.compare("semantics", run, {"class_recall_at1": found})

    print(f"{'table':<12} {'score':<26} {'runs':>5}  largest difference")
    for table, metric in comparison.count:
        print(f"{table:<12} {metric:<26} {comparison.count[table, metric]:>5}  {comparison.worst[table, metric]:.1e}")
    for kind, aris in alike.items():
        print(f"\n{kind}: scikit-learn's own clusters agree with ours by an adjusted Rand index of {np.mean(aris):.4f} (least {min(aris):.4f})", end="")
    found = {metric for _, metric in comparison.count}
    unknown = sorted({f"{table} {metric}" for table, metric in comparison.unknown if metric not in found})
    if unknown:
        print(f"\n\nnot computed anew: {', '.join(unknown)}", end="")
    print(f"\n{sum(comparison.count.values())} scores computed anew, {len(comparison.wrong)} differ by more than {TOLERANCE}")
    print("\n".join(comparison.wrong))
    if not comparison.count:
        print("nothing to compare: make the results with --dump", file=sys.stderr)
    sys.exit(1 if comparison.wrong or not comparison.count else 0)


if __name__ == "__main__":
    main()
