use flate2::Compression;
use flate2::write::ZlibEncoder;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use vantage_formats::ImportError;
use vantage_formats::mat5::{StructArray, Value, encode, read};

fn read_bytes(bytes: &[u8]) -> Result<BTreeMap<String, Value>, ImportError> {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    read(file.path())
}

fn message(bytes: &[u8]) -> String {
    read_bytes(bytes).unwrap_err().to_string()
}

fn sample() -> Value {
    Value::Structs(StructArray {
        fields: vec!["name".to_owned(), "translate_backward".to_owned(), "rest".to_owned()],
        elements: vec![
            vec![Value::Text("000110000010101.jpg".to_owned()), Value::scalar(-1.0), Value::empty()],
            vec![
                Value::Text(String::new()),
                Value::matrix(3, 3, (0..9).map(f64::from).collect()),
                Value::Cells(vec![Value::scalar(2.5), Value::Text("abc".to_owned())]),
            ],
        ],
    })
}

fn compressed(file: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&file[128..]).unwrap();
    let body = encoder.finish().unwrap();
    let mut out = file[..128].to_vec();
    out.extend(15_u32.to_le_bytes());
    out.extend((body.len() as u32).to_le_bytes());
    out.extend(body);
    out
}

#[test]
fn values_read_back() {
    let (structs, scale) = (sample(), Value::scalar(1500.0));
    let variables = read_bytes(&encode(&[("s", &structs), ("scale", &scale)])).unwrap();
    assert_eq!(variables, BTreeMap::from([("s".to_owned(), structs.clone()), ("scale".to_owned(), scale)]));
    assert_eq!(read_bytes(&compressed(&encode(&[("s", &structs)]))).unwrap()["s"], structs);
}

#[test]
fn every_truncation_is_an_error() {
    let file = encode(&[("s", &sample())]);
    for length in (0..file.len()).filter(|length| *length != 128) {
        assert!(read_bytes(&file[..length]).is_err(), "{length}");
    }
    let file = compressed(&file);
    for length in (0..file.len()).filter(|length| *length != 128) {
        assert!(read_bytes(&file[..length]).is_err(), "{length}");
    }
}

#[test]
fn claimed_sizes_do_not_allocate() {
    let file = encode(&[("x", &Value::matrix(2, 1, vec![1.0, 2.0]))]);
    let dims = 128 + 8 + 16 + 8;
    let mut huge = file.clone();
    huge[dims..dims + 8].copy_from_slice(&[0xff; 8]);
    assert!(message(&huge).contains("dimensions"), "{}", message(&huge));
    let mut many = file.clone();
    many[dims..dims + 4].copy_from_slice(&30_000_000_u32.to_le_bytes());
    assert!(message(&many).contains("got 2 numbers, expected 30000000"), "{}", message(&many));
    let mut long = file;
    long[132..136].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message(&long).contains("got 4294967295 bytes, expected at most"), "{}", message(&long));

    let mut cells = encode(&[("c", &Value::Cells(vec![Value::scalar(1.0)]))]);
    cells[dims + 4..dims + 8].copy_from_slice(&30_000_000_u32.to_le_bytes());
    assert!(message(&cells).contains("30000000 arrays"), "{}", message(&cells));
}

#[test]
fn a_bomb_is_refused() {
    let mut bomb = encode(&[]);
    bomb.extend(vec![0; 200 << 20]);
    let bomb = compressed(&bomb);
    assert!(bomb.len() < 1 << 20);
    assert!(message(&bomb).contains("at most 32 MiB when inflated"), "{}", message(&bomb));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image_structs.mat");
    crate::pipe(&path);
    assert!(read(&path).unwrap_err().to_string().contains("not a regular file"));
}

#[test]
fn arrays_in_arrays_end_somewhere() {
    let mut value = Value::scalar(1.0);
    for _ in 0..40 {
        value = Value::Cells(vec![value]);
    }
    assert!(message(&encode(&[("deep", &value)])).contains("at most 16 deep"));
}

#[test]
fn other_files_are_told_apart() {
    assert!(message(b"").contains("got 0 bytes"));
    assert!(message(b"\x89HDF\r\n\x1a\nrest").contains("7.3 (HDF5)"));
    let mut big = encode(&[]);
    big[124..128].copy_from_slice(&[1, 0, b'M', b'I']);
    assert!(message(&big).contains("big-endian"));
    assert!(message(&[0; 200]).contains("header"));
}

proptest! {
    #[test]
    fn changed_bytes_never_panic(changes in prop::collection::vec((0_usize..4096, any::<u8>()), 1..8)) {
        let mut file = encode(&[("s", &sample())]);
        let body = file.len() - 128;
        for (at, byte) in changes {
            file[128 + at % body] = byte;
        }
        let _ = read_bytes(&file);
    }
}
