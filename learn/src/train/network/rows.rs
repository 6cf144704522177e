//! Rows of numbers as tensors, and tensors as numbers.

use burn::tensor::{Device, Int, Tensor, TensorData};

/// Rows of a row-major table, gathered into a tensor `[views, width]`.
pub(crate) fn gather(table: &[f32], width: usize, views: &[usize], device: &Device) -> Tensor<2> {
    let mut rows = Vec::with_capacity(views.len() * width);
    for &view in views {
        rows.extend_from_slice(&table[view * width..(view + 1) * width]);
    }
    Tensor::from_data(TensorData::new(rows, [views.len(), width]), device)
}

/// Rows of a tensor, `[indices, width]`.
pub(crate) fn rows_of(table: &Tensor<2>, indices: &[i64], device: &Device) -> Tensor<2> {
    table.clone().select(0, Tensor::<1, Int>::from_data(TensorData::from(indices), device))
}

/// Numbers as a tensor `[rows, width]`, also where the width is 0.
pub(crate) fn table(numbers: Vec<f32>, rows: usize, device: &Device) -> Tensor<2> {
    let width = numbers.len() / rows.max(1);
    Tensor::from_data(TensorData::new(numbers, [rows, width]), device)
}

/// The numbers of a float tensor's data, to change.
pub(crate) fn floats(data: &mut TensorData) -> &mut [f32] {
    data.as_mut_slice().expect("a float tensor holds f32")
}

/// The numbers of a tensor, row-major.
pub(crate) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.try_into_vec_as().expect("a float tensor holds f32")
}
