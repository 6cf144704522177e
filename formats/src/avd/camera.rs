//! `cameras.txt`: intrinsics as COLMAP writes them.

use crate::Lens;
use crate::import::{FETCH_AGAIN, ImportError, read_file};
use std::path::Path;
use vantage_dataset::Camera;
use vantage_dataset::store::StoreError;

const FILE: &str = "cameras.txt";
const LARGEST: u64 = 1 << 20;

/// Reads the first camera of the scan's `cameras.txt`, or of `camera_params/<scan>/cameras.txt` beside the scan.
pub(super) fn read(scan: &Path) -> Result<(Camera, Lens), ImportError> {
    let beside = scan
        .parent()
        .zip(scan.file_name())
        .map(|(root, name)| root.join("camera_params").join(name).join(FILE));
    let path = [Some(scan.join(FILE)), beside].into_iter().flatten().find(|path| path.is_file());
    let path = path.unwrap_or_else(|| scan.join(FILE));
    let bytes = read_file(&path, LARGEST)?;
    let text = String::from_utf8_lossy(&bytes);
    let line = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let line = line.unwrap_or_default();
    parse(line).ok_or_else(|| {
        let expected =
            "`<id> OPENCV <width> <height> fx fy cx cy k1 k2 p1 p2`, or PINHOLE without the last four";
        ImportError::invalid(&path, "camera", line, expected, FETCH_AGAIN)
    })
}

fn parse(line: &str) -> Option<(Camera, Lens)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [_, model, width, height, parameters @ ..] = words.as_slice() else { return None };
    let (width, height): (u32, u32) = (width.parse().ok()?, height.parse().ok()?);
    let numbers: Vec<f64> = parameters.iter().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let (&[fx, fy, cx, cy], lens) = numbers.split_first_chunk()?;
    let lens = match (*model, lens) {
        ("OPENCV", &[k1, k2, p1, p2]) => Lens { k1, k2, p1, p2, k3: 0.0 },
        ("PINHOLE", []) => Lens::default(),
        _ => return None,
    };
    let sane = numbers.iter().all(|number| number.is_finite()) && fx > 0.0 && fy > 0.0;
    (sane && width > 0 && height > 0).then_some((Camera { width, height, fx, fy, cx, cy }, lens))
}

pub(super) fn write(scan: &Path, camera: &Camera) -> Result<(), StoreError> {
    let Camera { width, height, fx, fy, cx, cy } = *camera;
    let text = format!(
        "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n\
         # Number of cameras: 1\n1 OPENCV {width} {height} {fx} {fy} {cx} {cy} 0 0 0 0\n"
    );
    let path = scan.join(FILE);
    std::fs::write(&path, text).map_err(StoreError::write(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_camera_reads() {
        let line =
            "1 OPENCV 1920 1080 1049.51 1092.28 927.269 545.76 0.382444 0.105826 0.000859549 -0.00143275";
        let (camera, lens) = parse(line).unwrap();
        assert_eq!((camera.width, camera.fy, lens.k1, lens.p2), (1920, 1092.28, 0.382444, -0.00143275));
        for other in [
            "",
            "1 OPENCV 1920 1080 1049.51 1092.28 927.269",
            "1 FISHEYE 1920 1080 1 1 1 1 0 0 0 0",
            "1 PINHOLE 0 1080 1 1 1 1",
            "1 PINHOLE 1920 1080 nan 1 1 1",
        ] {
            assert!(parse(other).is_none(), "{other}");
        }
    }
}
