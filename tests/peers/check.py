"""Reads what `bench` writes with the libraries of others; see check.sh."""

import csv
import io
import json
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np

CASE = Path(__file__).parents[1] / "cases" / "small.yaml"
CIRCLE = "circle: { radius: 1.6 }\n  laps: 0.4\n  speed: 0.3\n  steps: 12"
CAMERA = "height: 1.25, yaw_deg: 90, pitch_deg: -16"
TURNTABLE = {
    "radius: 0.45": "radius: 0.2",
    "objects: 3": "objects: 1",
    CIRCLE: "turntable: { distance: 0.8, elevations_deg: [5, 20, 35, 50, 65], angles: 8 }",
    CAMERA: "height: 0.8, yaw_deg: 0, pitch_deg: 0",
}
APARTMENT = {
    CIRCLE: "grid: { spacing: 0.3, headings: 12, clearance: 0.35 }",
    CAMERA: "height: 1.25, yaw_deg: 0, pitch_deg: -16",
    "length: 6.5, width: 5.5": "length: 3.4, width: 3.2",
    "width: 320, height: 240": "width: 160, height: 120",
}


class Bench:
    def __init__(self, program, folder):
        self.program, self.folder = Path(program).resolve(), folder

    def scene(self, name, changes):
        text = CASE.read_text().replace("MODEL", str(Path("models/objects").resolve()))
        for old, new in changes.items():
            assert old in text, old
            text = text.replace(old, new)
        path = self.folder / f"{name}.yaml"
        path.write_text(text)
        return path

    def run(self, *arguments):
        subprocess.run([self.program, *arguments, "--renderer", "reference"], check=True, stdout=subprocess.DEVNULL)

    def dataset(self, scene, formats):
        out = self.folder / scene.stem
        self.run("dataset", scene, "--seeds", "2", "--format", formats, "--out", out)
        return out


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def image(data):
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(data)))


def our_covariances(episode):
    """Of the odometry in our own layout, of a right perturbation, rotation before translation."""
    covariances = []
    for row in rows(episode / "odometry.csv"):
        covariance = np.zeros((6, 6))
        for i in range(6):
            for j in range(i, 6):
                covariance[i, j] = covariance[j, i] = float(row[f"c{i}{j}"])
        covariances.append(covariance)
    return covariances


def our_crops(out):
    """Masked and boxed crops in our own layout, by episode, step and track."""
    crops = {}
    for folder in (path for path in sorted(out.iterdir()) if (path / "detections.csv").exists()):
        both = [np.load(folder / f"crops_{kind}.npy") for kind in ("masked", "boxed")]
        for row, masked, boxed in zip(rows(folder / "detections.csv"), *both, strict=True):
            crops[int(folder.name), int(row["step"]), int(row["track"])] = masked, boxed
    return crops


def evo_agrees_with_our_scores(bench, scene):
    from evo.core import metrics
    from evo.core.sync import associate_trajectories
    from evo.tools import file_interface

    out = bench.folder / "results"
    bench.run(scene, "--out", out, "--cache", bench.folder / "cache")
    checked = 0
    for row in rows(out / "small" / "trajectory.csv"):
        folder = out / "small" / row["seed"]
        truth = file_interface.read_tum_trajectory_file(folder / "truth.tum")
        estimate = file_interface.read_tum_trajectory_file(folder / f"{row['method']}.tum")
        truth, estimate = associate_trajectories(truth, estimate)
        step = metrics.RPE(metrics.PoseRelation.translation_part, delta=1, delta_unit=metrics.Unit.frames)
        step.process_data((truth, estimate))
        estimate.align_origin(truth)
        error = metrics.APE(metrics.PoseRelation.translation_part)
        error.process_data((truth, estimate))
        for ours, theirs in (("ate_m", error), ("rpe_translation_m", step)):
            root_mean_square = theirs.get_statistic(metrics.StatisticsType.rmse)
            assert abs(float(row[ours]) - root_mean_square) < 1e-6, (row, ours, root_mean_square)
        checked += 1
    return {"trajectories, ATE and RPE": checked}


def gtsam_reads_the_graph(out):
    import gtsam

    poses = edges = 0
    for path in sorted((out / "g2o").glob("*.g2o")):
        graph, values = gtsam.readG2o(str(path), True)
        assert graph.error(values) < 1e-9, graph.error(values)
        odometry = np.loadtxt(out / "tum" / path.stem / "odometry.tum")
        assert values.size() == len(odometry)
        for key, row in enumerate(odometry):
            pose = values.atPose3(key)
            quaternion = pose.rotation().toQuaternion()
            found = [*pose.translation(), quaternion.x(), quaternion.y(), quaternion.z(), quaternion.w()]
            found[3:] = np.sign(np.dot(found[3:], row[4:])) * np.array(found[3:])
            assert np.allclose(found, row[1:], atol=1e-9), (path, key)
            poses += 1
        stated = our_covariances(out / path.stem)
        assert graph.size() == len(stated) == len(odometry) - 1
        for index, covariance in enumerate(stated):
            # GTSAM's tangent is the rotation, then the translation, as ours.
            assert np.allclose(graph.at(index).noiseModel().covariance(), covariance, rtol=1e-6, atol=1e-12), (path, index)
            edges += 1
    return {"poses": poses, "edges with covariances": edges}


def pycocotools_reads_the_masks(out):
    from pycocotools import mask

    def decoded(runs):
        return mask.decode(mask.frPyObjects(runs, *runs["size"])) > 0

    checked = in_shards = 0
    for scene in sorted((out / "bop" / "test").iterdir()):
        coco = json.loads((scene / "scene_gt_coco.json").read_text())
        info = json.loads((scene / "scene_gt_info.json").read_text())
        of_image = {}
        for annotation in coco["annotations"]:
            number, index = annotation["image_id"], of_image.get(annotation["image_id"], 0)
            of_image[number] = index + 1
            seen = image((scene / "mask_visib" / f"{number:06}_{index:06}.png").read_bytes()) > 0
            runs = decoded(annotation["segmentation"])
            assert (runs == seen).all() and annotation["area"] == seen.sum()
            assert info[str(number)][index]["px_count_visib"] == seen.sum()
            checked += 1
    for shard in sorted((out / "bop-webdataset").glob("test_web/*.tar")):
        with tarfile.open(shard) as archive:
            members = {member.name: archive.extractfile(member).read() for member in archive}
        for name in (name for name in members if name.endswith(".mask_visib.json")):
            scene, number = name.split(".")[0].split("_")
            for index, runs in json.loads(members[name]).items():
                path = out / "bop" / "test" / scene / "mask_visib" / f"{number}_{int(index):06}.png"
                assert (decoded(runs) == (image(path.read_bytes()) > 0)).all(), name
                in_shards += 1
    return {"masks of bop": checked, "masks of bop-webdataset": in_shards}


def webdataset_reads_the_crops(out):
    import webdataset

    crops = our_crops(out)
    shards = [str(shard) for shard in sorted((out / "webdataset").glob("*.tar"))]
    read = 0
    for sample in webdataset.WebDataset(shards, shardshuffle=False).decode("rgb8"):
        labels = sample["json"]
        masked, boxed = crops[int(labels["episode"]), labels["step"], labels["track"]]
        assert (sample["masked.png"] == masked).all() and (sample["boxed.png"] == boxed).all()
        read += 1
    assert read == len(crops), (read, len(crops))
    return {"crops, masked and boxed": read}


def datasets_reads_the_crops(out, cache):
    import datasets

    crops = our_crops(out)
    datasets.disable_progress_bars()
    read = datasets.load_dataset(str(out / "parquet"), cache_dir=str(cache))["test"]
    assert len(read) == len(crops)
    for sample in read:
        masked, boxed = crops[int(sample["episode"]), sample["step"], sample["track"]]
        assert (np.asarray(sample["masked"]) == masked).all() and (np.asarray(sample["boxed"]) == boxed).all()
    return {"crops, masked and boxed": len(read)}


def is_rotation(matrix):
    assert np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-6) and np.linalg.det(matrix) > 0, matrix


def h5py_reads_the_poses(out):
    import h5py

    checked = 0
    for folder in (path for path in (out / "bigbird").iterdir() if path.is_dir()):
        with h5py.File(folder / "calibration.h5") as calibration:
            elevations, places = [], []
            to_reference = {camera: calibration[f"H_NP{camera}_from_NP5"][:] for camera in range(1, 6)}
            for path in sorted((folder / "poses").glob("NP5_*_pose.h5")):
                with h5py.File(path) as pose:
                    table_from_reference = pose["H_table_from_reference_camera"][:]
                for camera, camera_from_reference in to_reference.items():
                    table_from_camera = table_from_reference @ np.linalg.inv(camera_from_reference)
                    rotation = table_from_camera[:3, :3]
                    is_rotation(rotation)
                    elevations.append(-np.degrees(np.arcsin(rotation[2, 2])))
                    places.append(table_from_camera[:3, 3])
                    checked += 1
        assert np.allclose(sorted(elevations), np.repeat([5, 20, 35, 50, 65], len(elevations) // 5), atol=1e-3)
        # All cameras are 0.8 m from one point: the circumscribed sphere by linear least squares.
        places = np.array(places)
        equations = np.column_stack([2 * places, np.ones(len(places))])
        *center, rest = np.linalg.lstsq(equations, (places**2).sum(1), rcond=None)[0]
        assert abs(np.sqrt(rest + np.square(center).sum()) - 0.8) < 1e-3
    return {"camera poses, at the scene's elevations and distance": checked}


def scipy_reads_the_structs(out):
    from scipy.io import loadmat

    checked = 0
    for home in (path for path in sorted((out / "avd").iterdir()) if path.is_dir()):
        read = loadmat(home / "image_structs.mat")
        scale, structs = float(read["scale"].squeeze()), read["image_structs"][0]
        names = {path.name for path in (home / "jpg_rgb").iterdir()}
        annotations = json.loads((home / "annotations.json").read_text())
        assert {str(struct["image_name"][0]) for struct in structs} == names == set(annotations) and scale == 1000
        for struct in structs:
            rotation, translation = struct["R"], struct["t"]
            is_rotation(rotation)
            assert np.allclose(-rotation.T @ translation, struct["world_pos"], atol=1e-6)
            assert np.allclose(rotation.T[:, 2], struct["direction"].squeeze(), atol=1e-6)
            checked += 1
    return {"images": checked}


def main(program, folder):
    folder = Path(folder).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    bench = Bench(program, folder)
    small = bench.scene("small", {})
    out = bench.dataset(small, "vantage,bop,bop-webdataset,webdataset,parquet,tum,g2o")
    turntable = bench.dataset(bench.scene("turntable", TURNTABLE), "bigbird")
    apartment = bench.dataset(bench.scene("apartment", APARTMENT), "avd")
    checks = [
        ("evo", lambda: evo_agrees_with_our_scores(bench, small)),
        ("GTSAM", lambda: gtsam_reads_the_graph(out)),
        ("pycocotools", lambda: pycocotools_reads_the_masks(out)),
        ("webdataset", lambda: webdataset_reads_the_crops(out)),
        ("datasets", lambda: datasets_reads_the_crops(out, folder / "hugging-face")),
        ("h5py", lambda: h5py_reads_the_poses(turntable)),
        ("SciPy", lambda: scipy_reads_the_structs(apartment)),
    ]
    for name, check in checks:
        counts = check()
        assert all(counts.values()), f"{name} read nothing: {counts}"
        print(f"{name}:", ", ".join(f"{count} {what}" for what, count in counts.items()), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
