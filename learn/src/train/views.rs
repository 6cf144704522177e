//! Views as a training reads them: by instance, with their conditioning, and in batches.

use super::error::TrainError;
use burn::tensor::{Device, Tensor, TensorData};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Split, ViewSet};

/// A view set, checked and indexed.
pub(crate) struct Views<'a> {
    pub(crate) set: &'a ViewSet,
    /// `[views, CONDITIONING]`, row-major.
    pub(crate) conditioning: Vec<f32>,
    /// Views of each instance that has two or more.
    pub(crate) by_instance: Vec<Vec<usize>>,
}

impl<'a> Views<'a> {
    /// Views of a split, finite and with at least `instances` instances to learn from.
    pub(crate) fn new(set: &'a ViewSet, split: Split, instances: usize) -> Result<Self, TrainError> {
        if set.split != split {
            return Err(TrainError::Split { got: set.split, expected: split });
        }
        let mut conditioning = Vec::with_capacity(set.views.len() * CONDITIONING);
        let mut by_instance = vec![Vec::new(); set.instances.len()];
        for (index, view) in set.views.iter().enumerate() {
            let x = view.viewpoint.conditioning().map(|number| number as f32);
            if !x.iter().all(|number| number.is_finite()) {
                return Err(TrainError::Viewpoint { split, view: index });
            }
            conditioning.extend(x);
            let Some(views) = by_instance.get_mut(view.instance) else {
                let (got, instances) = (view.instance, set.instances.len());
                return Err(TrainError::Instance { split, view: index, got, instances });
            };
            views.push(index);
        }
        by_instance.retain(|views| views.len() >= 2);
        if by_instance.len() < instances {
            return Err(TrainError::TooFewInstances { split, got: by_instance.len(), expected: instances });
        }
        Ok(Self { set, conditioning, by_instance })
    }

    /// Number of views.
    pub(crate) fn len(&self) -> usize {
        self.set.views.len()
    }

    /// The crops of some views.
    pub(crate) fn crops(&self, views: impl Iterator<Item = usize>) -> Vec<&Crop> {
        views.map(|view| &self.set.views[view].crop).collect()
    }

    /// The conditioning of a view.
    pub(crate) fn conditioning(&self, view: usize) -> &[f32] {
        &self.conditioning[view * CONDITIONING..(view + 1) * CONDITIONING]
    }
}

/// BLAKE3 of all that a training reads of a view set.
pub fn view_set_hash(set: &ViewSet) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(set.split.name().as_bytes());
    hasher.update(&(set.instances.len() as u64).to_le_bytes());
    for instance in &set.instances {
        hasher.update(&instance.id.0.to_le_bytes());
    }
    for view in &set.views {
        hasher.update(&(view.instance as u64).to_le_bytes());
        for number in view.viewpoint.conditioning() {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(&*view.crop.0);
    }
    hasher.finalize().to_hex().to_string()
}

/// Rows of a row-major table, gathered into a tensor `[views, width]`.
pub(crate) fn gather(table: &[f32], width: usize, views: &[usize], device: &Device) -> Tensor<2> {
    let mut rows = Vec::with_capacity(views.len() * width);
    for &view in views {
        rows.extend_from_slice(&table[view * width..(view + 1) * width]);
    }
    Tensor::from_data(TensorData::new(rows, [views.len(), width]), device)
}

/// The numbers of a tensor, row-major.
pub(crate) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.try_into_vec_as().expect("a float tensor holds f32")
}
