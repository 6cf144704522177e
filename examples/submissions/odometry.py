"""Answers a task by odometry alone, with NumPy and SciPy: the least that a submission can be.

    head -c 32 /dev/urandom | base64 > secret
    bench task ring --episodes 4 --secret secret --out task --truth sealed
    python examples/submissions/odometry.py task mine
    bench score sealed mine --task task
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation


def dead_reckoning(episode):
    """The times of an episode, and the robot's poses `[n, 4, 4]` by its odometry."""
    with open(episode / "timestamps.csv") as file:
        times = [row["timestamp"] for row in csv.DictReader(file)]
    poses = [np.eye(4)]
    with open(episode / "odometry.csv") as file:
        for row in csv.DictReader(file):
            step = np.eye(4)
            step[:3, :3] = Rotation.from_quat([float(row[k]) for k in ("qx", "qy", "qz", "qw")]).as_matrix()
            step[:3, 3] = [float(row[k]) for k in ("tx", "ty", "tz")]
            poses.append(poses[-1] @ step)
    return times, np.array(poses)


def write_trajectory(path, times, poses):
    lines = []
    for time, pose in zip(times, poses):
        numbers = [*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
        lines.append(" ".join([time, *(repr(float(number)) for number in numbers)]))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def main():
    task, out = Path(sys.argv[1]), Path(sys.argv[2])
    about = json.loads((task / "task.json").read_text())
    for number in range(about["episodes"]):
        times, poses = dead_reckoning(task / str(number))
        write_trajectory(out / "trajectories" / f"{number}.tum", times, poses)
    lines = ["name: dead_reckoning", "division: open", f"task: {about['truth']}", "description: odometry alone"]
    (out / "submission.yaml").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
