"""Answers a task with GTSAM: odometry, and the centres of boxes as projections of points, one an object. Needs gtsam, numpy and scipy.

    head -c 32 /dev/urandom | base64 > secret
    bench task ring --episodes 4 --secret secret --out task --truth sealed
    python examples/submissions/gtsam_bearings.py task mine
    bench score sealed mine --task task

The task has to tell which detections are of one object (`--association given`). It answers with trajectories and with maps of centres.
"""

import csv
import json
import sys
from collections import defaultdict
from pathlib import Path

import gtsam
import numpy as np
from gtsam.symbol_shorthand import O, X
from odometry import dead_reckoning, write_trajectory
from scipy.spatial.transform import Rotation

PIXELS = 3.0  # standard deviation of a box's centre from the projection of the object's
LEAST_VIEWS = 3


def pose3(numbers):
    t, q = numbers[:3], numbers[3:]
    return gtsam.Pose3(gtsam.Rot3(Rotation.from_quat(q).as_matrix()), np.array(t))


def covariance(row):
    """Rotation before translation, as GTSAM has it; the file holds the upper triangle by rows."""
    upper = [float(value) for key, value in row.items() if key[0] == "c"]
    matrix = np.zeros((6, 6))
    matrix[np.triu_indices(6)] = upper
    return matrix + np.triu(matrix, 1).T


def rays_meet(origins, directions):
    """The point nearest to all lines, by least squares; none where they are parallel."""
    parts = np.eye(3)[None] - directions[:, :, None] * directions[:, None]
    total = parts.sum(axis=0)
    if np.linalg.eigvalsh(total)[0] < 1e-3:
        return None
    return np.linalg.solve(total, np.einsum("nij,nj->i", parts, origins))


def solve(episode):
    times, poses = dead_reckoning(episode)
    camera = json.loads((episode / "camera.json").read_text())
    fx, fy, cx, cy = (camera["intrinsics"][key] for key in ("fx", "fy", "cx", "cy"))
    robot_from_camera = pose3(camera["robot_from_camera"])
    calibration = gtsam.Cal3_S2(fx, fy, 0.0, cx, cy)

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(gtsam.PriorFactorPose3(X(0), gtsam.Pose3(), gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)))
    for step, pose in enumerate(poses):
        values.insert(X(step), gtsam.Pose3(pose))
    with open(episode / "odometry.csv") as file:
        for row in csv.DictReader(file):
            moved = pose3([float(row[k]) for k in ("tx", "ty", "tz", "qx", "qy", "qz", "qw")])
            noise = gtsam.noiseModel.Gaussian.Covariance(covariance(row))
            graph.add(gtsam.BetweenFactorPose3(X(int(row["from"])), X(int(row["to"])), moved, noise))

    views = defaultdict(list)
    with open(episode / "detections.csv") as file:
        for row in csv.DictReader(file):
            center = np.array([float(row["min_x"]) + float(row["max_x"]), float(row["min_y"]) + float(row["max_y"])]) / 2
            views[int(row["track"])].append((int(row["step"]), center))
    noise = gtsam.noiseModel.Robust.Create(
        gtsam.noiseModel.mEstimator.Huber.Create(1.345), gtsam.noiseModel.Isotropic.Sigma(2, PIXELS)
    )
    camera_matrix = robot_from_camera.matrix()
    placed = []
    for track, seen in views.items():
        in_world = [poses[step] @ camera_matrix for step, _ in seen]
        rays = np.array([[(u - cx) / fx, (v - cy) / fy, 1.0] for _, (u, v) in seen])
        rays = np.array([pose[:3, :3] @ ray / np.linalg.norm(ray) for pose, ray in zip(in_world, rays)])
        point = rays_meet(np.array([pose[:3, 3] for pose in in_world]), rays) if len(seen) >= LEAST_VIEWS else None
        if point is None:
            continue
        placed.append(track)
        values.insert(O(track), point)
        graph.add(gtsam.PriorFactorPoint3(O(track), point, gtsam.noiseModel.Isotropic.Sigma(3, 10.0)))
        for step, center in seen:
            factor = gtsam.GenericProjectionFactorCal3_S2(
                center, noise, X(step), O(track), calibration, False, False, robot_from_camera
            )
            graph.add(factor)
    found = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    trajectory = np.array([found.atPose3(X(step)).matrix() for step in range(len(poses))])
    return times, trajectory, {track: found.atPoint3(O(track)) for track in placed}


def main():
    task, out = Path(sys.argv[1]), Path(sys.argv[2])
    about = json.loads((task / "task.json").read_text())
    if about["association"] != "given":
        sys.exit("this sample needs a task of --association given")
    (out / "maps").mkdir(parents=True, exist_ok=True)
    for number in range(about["episodes"]):
        times, poses, objects = solve(task / str(number))
        write_trajectory(out / "trajectories" / f"{number}.tum", times, poses)
        rows = "".join(f"{x},{y},{z}\n" for x, y, z in objects.values())
        (out / "maps" / f"{number}.csv").write_text("x,y,z\n" + rows)
    lines = ["name: gtsam_bearings", "division: open", f"task: {about['truth']}", "description: bearings and odometry"]
    (out / "submission.yaml").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
