use super::*;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::{Field, RowAccessor};
use serde_json::{Value, json};

fn pixels(png: &[u8]) -> Vec<u8> {
    image::load_from_memory_with_format(png, image::ImageFormat::Png).unwrap().into_rgb8().into_raw()
}

#[test]
fn webdataset_holds_every_sample_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let samples = samples(25);
    let manifest = write_crops(folder.path(), crop_options(CropLayout::WebDataset, 10), samples.clone());
    let names: Vec<_> = manifest.shards.iter().map(|shard| (shard.name.as_str(), shard.samples)).collect();
    assert_eq!(names[..3], [("train-000000.tar", 10), ("train-000001.tar", 10), ("train-000002.tar", 5)]);
    assert_eq!(names[3..], [("test-000000.tar", 10), ("test-000001.tar", 10), ("test-000002.tar", 5)]);

    let members: Vec<_> =
        manifest.shards.iter().flat_map(|shard| members(&folder.path().join(&shard.name))).collect();
    assert_eq!(members.len(), 3 * samples.len());
    for (_, _, header) in &members {
        let owner = (header.uid().unwrap(), header.gid().unwrap());
        assert_eq!((header.mtime().unwrap(), owner, header.mode().unwrap()), (0, (0, 0), 0o644));
    }
    for (sample, parts) in samples.iter().zip(members.chunks(3)) {
        let key = format!("{}-{:06}-{:04}", sample.episode, sample.step, sample.track);
        let names: Vec<_> = parts.iter().map(|(name, _, _)| name.strip_prefix(&key).unwrap()).collect();
        assert_eq!(names, [".masked.png", ".boxed.png", ".json"]);
        assert_eq!(pixels(&parts[0].1), *sample.masked_crop.0);
        assert_eq!(pixels(&parts[1].1), *sample.boxed_crop.0);
        let labels: Value = serde_json::from_slice(&parts[2].1).unwrap();
        assert_eq!(labels["episode"], sample.episode.to_string());
        assert_eq!(labels["instance"], format!("{:016x}", sample.instance.0));
        assert_eq!(labels["family"], sample.family);
        assert_eq!(labels["split"], sample.split.name());
        assert_eq!(labels["timestamp"], sample.timestamp);
        let Camera { width, height, fx, fy, cx, cy } = sample.camera;
        let camera = json!({"width": width, "height": height, "fx": fx, "fy": fy, "cx": cx, "cy": cy});
        assert_eq!(labels["camera"], camera);
        let (t, q) = (sample.world_from_camera.translation.vector, sample.world_from_camera.rotation.coords);
        assert_eq!(labels["world_from_camera"], json!([t.x, t.y, t.z, q.x, q.y, q.z, q.w]));
        let viewpoint = sample.viewpoint.map(|v| {
            json!({"direction": [v.direction.x, v.direction.y, v.direction.z],
                   "roll": v.roll, "log_distance": v.log_distance})
        });
        assert_eq!(labels["viewpoint"], json!(viewpoint));
    }
}

#[test]
fn parquet_holds_every_sample_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let samples = samples(1100);
    let manifest = write_crops(folder.path(), crop_options(CropLayout::Parquet, 1050), samples.clone());
    let names: Vec<_> = manifest.shards.iter().map(|shard| shard.name.as_str()).collect();
    assert_eq!(names[..2], ["data/train-00000.parquet", "data/train-00001.parquet"]);
    assert_eq!(names[2..], ["data/test-00000.parquet", "data/test-00001.parquet"]);
    let mut expected = samples.iter();
    for name in names {
        let reader = SerializedFileReader::new(File::open(folder.path().join(name)).unwrap()).unwrap();
        let metadata = reader.metadata().file_metadata().key_value_metadata().unwrap();
        let features = metadata.iter().find(|entry| entry.key == "huggingface").unwrap();
        let features: Value = serde_json::from_str(features.value.as_ref().unwrap()).unwrap();
        assert_eq!(features["info"]["features"]["masked"], json!({"_type": "Image"}));
        for row in reader.get_row_iter(None).unwrap() {
            let (row, sample) = (row.unwrap(), expected.next().unwrap());
            let key = format!("{}-{:06}-{:04}", sample.episode, sample.step, sample.track);
            assert_eq!(row.get_string(0).unwrap(), &key);
            for (column, crop, ending) in
                [(1, &sample.masked_crop, "masked"), (2, &sample.boxed_crop, "boxed")]
            {
                let image = row.get_group(column).unwrap();
                assert_eq!(pixels(image.get_bytes(0).unwrap().data()), *crop.0);
                assert_eq!(image.get_string(1).unwrap(), &format!("{key}.{ending}.png"));
            }
            assert_eq!(row.get_ulong(3).unwrap(), sample.episode);
            assert_eq!(row.get_double(5).unwrap(), sample.timestamp);
            let Camera { width, height, fx, fy, cx, cy } = sample.camera;
            let size = [row.get_ulong(14).unwrap(), row.get_ulong(15).unwrap()];
            assert_eq!(size, [u64::from(width), u64::from(height)]);
            assert_eq!([16, 17, 18, 19].map(|column| row.get_double(column).unwrap()), [fx, fy, cx, cy]);
            assert_eq!(row.get_string(8).unwrap(), &sample.family);
            assert_eq!(row.get_double(11).unwrap(), sample.bounding_box.max.x);
            let pose = row.get_list(21).unwrap();
            let number = |field: &Field| match field {
                Field::Double(number) => *number,
                other => panic!("{other:?}"),
            };
            let pose: Vec<_> = pose.elements().iter().map(number).collect();
            let (t, q) =
                (sample.object_from_camera.translation.vector, sample.object_from_camera.rotation.coords);
            assert_eq!(pose, [t.x, t.y, t.z, q.x, q.y, q.z, q.w]);
            let roll = row.get_double(25).ok();
            assert_eq!(roll, sample.viewpoint.map(|v| v.roll));
        }
    }
    assert!(expected.next().is_none());
    let card = fs::read_to_string(folder.path().join("README.md")).unwrap();
    for line in [
        "license: \"cc0-1.0\"",
        "pretty_name: \"Crops: \\\"a test\\\"\"",
        "  - split: train\n    path: data/train-*.parquet",
        "  - name: test\n    num_bytes: ",
        "    num_examples: 1100",
        "- CC-BY-4.0",
        "  - name: fx\n    dtype: float64",
        "| `cx` | principal point, x, pixels; pixel centres at +0.5 |",
    ] {
        assert!(card.contains(line), "{line} in {card}");
    }
}

#[test]
fn an_empty_dataset_is_a_dataset() {
    for layout in [CropLayout::WebDataset, CropLayout::Parquet] {
        let folder = tempfile::tempdir().unwrap();
        let manifest = write_crops(folder.path(), crop_options(layout, 10), Vec::new());
        assert_eq!((manifest.samples, manifest.shards.len()), (0, 0));
        assert_eq!(verify_layout(folder.path()).unwrap(), manifest);
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    for layout in [CropLayout::WebDataset, CropLayout::Parquet] {
        let written = [1, 2, 7].map(|threads| {
            let folder = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| write_crops(folder.path(), crop_options(layout, 400), samples(600)));
            files(folder.path())
        });
        assert!(written[0] == written[1] && written[1] == written[2]);
    }
}
