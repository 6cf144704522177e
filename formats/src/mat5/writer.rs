//! Writes MAT-files.

use super::value::{StructArray, Value};
use super::{class, kind};

/// The header's text, without the date that MATLAB puts there, so that equal variables make equal files.
const TEXT: &str = "MATLAB 5.0 MAT-file, Platform: any, Created by: Vantage";
/// Bytes of a field's name, its closing 0 included.
const FIELD_WIDTH: usize = 32;

/// The bytes of a MAT-file with these variables, in this order, uncompressed.
///
/// Text must be ASCII, fields shorter than 32 characters. [`Value::Other`] is written as `[]`.
pub fn encode(variables: &[(&str, &Value)]) -> Vec<u8> {
    let mut file = format!("{TEXT:<116}").into_bytes();
    file.extend([0; 8]);
    file.extend([0x00, 0x01, b'I', b'M']);
    for (name, value) in variables {
        put_matrix(&mut file, name, value);
    }
    file
}

fn put_matrix(out: &mut Vec<u8>, name: &str, value: &Value) {
    let mut body = Vec::new();
    match value {
        Value::Numbers { dims, data } => {
            put_head(&mut body, class::DOUBLE, dims, name);
            put(&mut body, kind::DOUBLE, &data.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        }
        Value::Text(text) => {
            put_head(&mut body, class::CHAR, &[1, text.chars().count()], name);
            put(&mut body, kind::UTF8, text.as_bytes());
        }
        Value::Structs(structs) => {
            put_head(&mut body, class::STRUCT, &[1, structs.elements.len()], name);
            put_structs(&mut body, structs);
        }
        Value::Cells(cells) => {
            put_head(&mut body, class::CELL, &[1, cells.len()], name);
            cells.iter().for_each(|cell| put_matrix(&mut body, "", cell));
        }
        Value::Other(_) => {
            put_head(&mut body, class::DOUBLE, &[0, 0], name);
            put(&mut body, kind::DOUBLE, &[]);
        }
    }
    put(out, kind::MATRIX, &body);
}

fn put_head(out: &mut Vec<u8>, class: u8, dims: &[usize], name: &str) {
    put(out, kind::UINT32, &[class, 0, 0, 0, 0, 0, 0, 0]);
    put(
        out,
        kind::INT32,
        &dims.iter().flat_map(|extent| (*extent as i32).to_le_bytes()).collect::<Vec<u8>>(),
    );
    put(out, kind::INT8, name.as_bytes());
}

fn put_structs(out: &mut Vec<u8>, structs: &StructArray) {
    put(out, kind::INT32, &(FIELD_WIDTH as i32).to_le_bytes());
    let mut names = vec![0; FIELD_WIDTH * structs.fields.len()];
    for (place, field) in names.chunks_exact_mut(FIELD_WIDTH).zip(&structs.fields) {
        let length = field.len().min(FIELD_WIDTH - 1);
        place[..length].copy_from_slice(&field.as_bytes()[..length]);
    }
    put(out, kind::INT8, &names);
    structs.elements.iter().flatten().for_each(|value| put_matrix(out, "", value));
}

/// An element: short ones are put into their tag, as MATLAB does.
fn put(out: &mut Vec<u8>, kind: u32, body: &[u8]) {
    let length = body.len() as u32;
    if kind != kind::MATRIX && (1..=4).contains(&length) {
        out.extend((length << 16 | kind).to_le_bytes());
        out.extend(body);
        out.extend(vec![0; 4 - body.len()]);
        return;
    }
    out.extend(kind.to_le_bytes());
    out.extend(length.to_le_bytes());
    out.extend(body);
    out.extend(vec![0; body.len().next_multiple_of(8) - body.len()]);
}
