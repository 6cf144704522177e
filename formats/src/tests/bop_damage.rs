//! Damaged copies of a dataset of BOP: what is read of them can be stored.

use super::bop_import::{Outlines, try_read, written};
use super::*;
use vantage_dataset::store::write_episode;

/// A copy with a byte changed, or its end cut off, or, where it is text, a number replaced by one that nobody measures.
fn damage(bytes: &[u8], stream: &mut Stream) -> Vec<u8> {
    const NUMBERS: [&str; 8] =
        ["0", "-1", "1e308", "1e-308", "4294967296", "18446744073709551615", "null", "[]"];
    let mut damaged = bytes.to_vec();
    let at = stream.below(bytes.len());
    match stream.below(3) {
        0 => damaged[at] = stream.below(256) as u8,
        1 => damaged.truncate(at),
        _ => {
            let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.');
            let Some(start) = (at..bytes.len()).find(|&i| is_number(&bytes[i])) else { return damaged };
            let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
            let other = NUMBERS[stream.below(NUMBERS.len())];
            damaged.splice(start..start + length, other.bytes());
        }
    }
    damaged
}

#[test]
fn of_damaged_files_what_is_read_can_be_stored_or_is_an_error() {
    const COPIES: u64 = 150;
    let (folder, _) = written();
    let stored = tempfile::tempdir().unwrap();
    for file in [
        "models/models_info.json",
        "models/obj_000002.ply",
        "train/000000/scene_camera.json",
        "train/000000/scene_gt.json",
        "train/000000/scene_gt_info.json",
        "train/000000/rgb/000000.png",
        "train/000000/mask_visib/000000_000000.png",
    ] {
        let path = folder.path().join(file);
        let whole = fs::read(&path).unwrap();
        let (mut arranged, mut told) = (0, 0);
        for copy in 0..COPIES {
            fs::write(&path, damage(&whole, &mut Seed(copy).stream(file, 0))).unwrap();
            let Ok((arrangements, report)) = try_read(folder.path(), &mut Outlines) else {
                told += 1;
                continue;
            };
            told += usize::from(!report.skipped.is_empty());
            arranged += arrangements.len();
            for (number, BopArrangement { episode, .. }) in arrangements.iter().enumerate() {
                let place =
                    stored.path().join(format!("{}_{copy}_{number}", path.file_name().unwrap().display()));
                write_episode(&place, episode, Provenance::new())
                    .unwrap_or_else(|error| panic!("{file}, {copy}: {error}"));
                fs::remove_dir_all(&place).unwrap();
            }
        }
        fs::write(&path, whole).unwrap();
        assert!(arranged > 5 && told > 20, "{file}: {arranged} arrangements read, {told} copies told of");
    }
}
