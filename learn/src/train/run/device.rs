//! What computes a training: the CPU, or a GPU where wgpu finds one.

#[cfg(feature = "gpu")]
use crate::train::error::TrainError;
use burn::module::Module;
use burn::tensor::Device;
#[cfg(feature = "gpu")]
use burn::tensor::{DeviceIdentity, DeviceType};

/// What the tensors of a training live on; by default the CPU's memory.
#[derive(Clone, Debug, Default)]
pub struct TrainingDevice {
    gpu: Option<Gpu>,
}

#[derive(Clone, Debug)]
struct Gpu {
    device: Device,
    name: String,
}

impl TrainingDevice {
    /// The first GPU that wgpu finds, of which software renderers are none.
    ///
    /// Sums are taken in another order there: its models differ from the CPU's in the last digits, and from run to run.
    #[cfg(feature = "gpu")]
    pub fn gpu() -> Result<Self, TrainError> {
        Self::first(|identity| identity.physical.is_some()).ok_or(TrainError::NoGpu)
    }

    #[cfg(feature = "gpu")]
    fn first(wanted: impl Fn(&DeviceIdentity) -> bool) -> Option<Self> {
        Device::enumerate(DeviceType::Wgpu).into_vec().into_iter().find_map(|device| {
            let identity = device.identity().filter(&wanted)?;
            Some(Self { gpu: Some(Gpu { device, name: identity.name }) })
        })
    }

    /// Whatever wgpu finds, a renderer in software too.
    #[cfg(all(test, feature = "gpu"))]
    pub(crate) fn any() -> Self {
        Self::first(|_| true).expect("a Vulkan driver, if only lavapipe")
    }

    /// Name of the GPU; none of the CPU.
    pub fn name(&self) -> Option<&str> {
        self.gpu.as_ref().map(|gpu| gpu.name.as_str())
    }

    /// A module, with derivatives as before, on the CPU.
    pub(crate) fn to_cpu<M: Module>(&self, module: M) -> M {
        if self.gpu.is_none() { module } else { module.valid().to_device(&Device::flex()).train() }
    }

    /// With derivatives.
    pub(crate) fn tensors(&self) -> Device {
        self.gpu.as_ref().map_or_else(cpu, |gpu| gpu.device.clone().autodiff())
    }
}

/// The CPU, with derivatives.
pub(crate) fn cpu() -> Device {
    Device::flex().autodiff()
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::spec::{Objective, TrainingSpec};
    use crate::train::{CURVE_TABLE, Training, synthetic, train};
    use std::collections::BTreeMap;
    use std::ops::ControlFlow;
    use vantage_dataset::{Seed, Split};

    /// Stage, step and loss of each row of the loss curve.
    fn losses(device: &TrainingDevice, objective: Objective) -> Vec<(String, f64)> {
        let folder = tempfile::tempdir().unwrap();
        let (training, validation) =
            (synthetic::views(Split::Train, 6, 8, 1), synthetic::views(Split::Validation, 6, 8, 2));
        let spec = TrainingSpec {
            objective,
            trunk_steps: 6,
            trunk_batch: 8,
            steps: 6,
            batch: 4,
            views: 4,
            context: 3,
            latent_dim: 30,
            pairs_per_harmonic: 2,
            measurement_dim: 6,
            ..TrainingSpec::default()
        };
        let asked = Training {
            training: &training,
            validation: &validation,
            spec: &spec,
            seed: Seed(0),
            provenance: &BTreeMap::new(),
            folder: folder.path(),
            trunks: None,
            device,
        };
        train(asked, &mut |_| ControlFlow::Continue(())).unwrap();
        let table = std::fs::read_to_string(folder.path().join(CURVE_TABLE)).unwrap();
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            (format!("{} {}", cells[0], cells[1]), cells[2].parse().unwrap())
        };
        table.lines().skip(1).map(row).collect()
    }

    #[test]
    fn a_training_by_wgpu_descends_as_on_the_cpu() {
        for objective in [Objective::ViewpointDependent, Objective::Contrastive] {
            let (here, there) =
                (losses(&TrainingDevice::default(), objective), losses(&TrainingDevice::any(), objective));
            assert_eq!((here.len(), there.len()), (12, 12));
            for ((step, here), (_, there)) in here.iter().zip(&there) {
                assert!((here - there).abs() < 1e-3 * here.abs().max(1.0), "{step}: {here} and {there}");
            }
        }
    }
}
