//! The trunk's convolutions, forwards and backwards, over cache-sized groups of crops.
//!
//! Each group's patches are gathered into a matrix, so that a layer is one product of matrices; two to three times
//! faster here than burn's own convolutions, against which the tests check it. Groups run in parallel and
//! are added up in order, so that the thread count changes nothing.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::widest::widest;

use crate::train::network::PIXEL_CENTER;
use crate::train::network::weights::KERNEL;

const TAPS: usize = KERNEL * KERNEL;
/// Channels of a crop.
const CHANNELS: usize = 3;
/// Crops in a group.
const GROUP: usize = 16;
/// Terms of a product's sum that are added up before they join the rest: another number rounds differently, and `bench train`
/// would no longer make the committed models again.
const BLOCK: usize = 256;

/// Layers `relu(conv(x))`, each halving the side.
pub(crate) struct Convolutions {
    layers: Vec<Layer>,
}

struct Layer {
    /// `[outputs, TAPS * inputs]`: kernel row, kernel column, channel.
    weight: DMatrix<f32>,
    bias: DVector<f32>,
}

/// What a group of crops left behind on its way forwards.
struct Trace {
    /// Of each layer: `[TAPS * inputs, positions]`.
    patches: Vec<DMatrix<f32>>,
    /// Of each layer: `[outputs, positions]`; position by crop, row, column.
    outputs: Vec<DMatrix<f32>>,
}

/// A pass forwards, from which one goes backwards.
pub(crate) struct Pass {
    traces: Vec<Trace>,
}

/// Derivatives to a layer's weight, `[outputs, TAPS * inputs]` row-major, and bias.
pub(crate) struct LayerGradient {
    pub(crate) weight: Vec<f32>,
    pub(crate) bias: Vec<f32>,
}

impl Convolutions {
    /// From each layer's weight, `[outputs, TAPS * inputs]` row-major, and bias.
    pub(crate) fn new(layers: impl Iterator<Item = (Vec<f32>, Vec<f32>)>) -> Self {
        let layer = |(weight, bias): (Vec<f32>, Vec<f32>)| Layer {
            weight: DMatrix::from_row_slice(bias.len(), weight.len() / bias.len(), &weight),
            bias: DVector::from_vec(bias),
        };
        Self { layers: layers.map(layer).collect() }
    }

    /// The pass of some crops.
    pub(crate) fn pass(&self, crops: &[&Crop]) -> Pass {
        Pass { traces: crops.par_chunks(GROUP).map(|group| self.trace(group)).collect() }
    }

    fn trace(&self, crops: &[&Crop]) -> Trace {
        let mut trace = Trace { patches: Vec::new(), outputs: Vec::new() };
        let mut side = CROP_SIDE;
        let centered = centered(crops);
        for layer in &self.layers {
            let input = trace.outputs.last().map_or(&centered[..], |output| output.as_slice());
            let patches = gathered(input, layer.inputs(), side);
            let mut output = product(view(&layer.weight), view(&patches));
            rectify(output.as_mut_slice(), layer.bias.as_slice());
            trace.patches.push(patches);
            trace.outputs.push(output);
            side /= 2;
        }
        trace
    }

    /// The layers' derivatives, given those to the outputs of a pass.
    pub(crate) fn backward(&self, pass: Pass, d_outputs: &[f32]) -> Vec<LayerGradient> {
        let size = |trace: &Trace| trace.outputs.last().map_or(0, |output| output.len());
        let mut starts = vec![0];
        starts.extend(pass.traces.iter().scan(0, |end, trace| {
            *end += size(trace);
            Some(*end)
        }));
        let groups = pass.traces.into_par_iter().zip(starts.par_windows(2));
        let gradients: Vec<Vec<(DMatrix<f32>, DVector<f32>)>> = groups
            .map(|(trace, range)| self.group_gradients(trace, &d_outputs[range[0]..range[1]]))
            .collect();
        let mut sums = gradients.into_iter();
        let first = sums.next().unwrap_or_default();
        let total = sums.fold(first, |mut total, group| {
            for ((weight, bias), (more_weight, more_bias)) in total.iter_mut().zip(group) {
                *weight += more_weight;
                *bias += more_bias;
            }
            total
        });
        let row_major = |(weight, bias): (DMatrix<f32>, DVector<f32>)| LayerGradient {
            weight: weight.transpose().as_slice().to_vec(),
            bias: bias.as_slice().to_vec(),
        };
        total.into_iter().map(row_major).collect()
    }

    /// First layer first.
    fn group_gradients(&self, trace: Trace, d_outputs: &[f32]) -> Vec<(DMatrix<f32>, DVector<f32>)> {
        let mut gradients = Vec::new();
        let mut d_input = d_outputs.to_vec();
        let traced = trace.patches.into_iter().zip(trace.outputs);
        for ((index, layer), (mut patches, output)) in self.layers.iter().enumerate().zip(traced).rev() {
            mask(&mut d_input, output.as_slice());
            let d_output = DMatrix::from_vec(output.nrows(), output.ncols(), d_input);
            let weight = product(view(&d_output), view(&patches).transpose());
            gradients.push((weight, d_output.column_sum()));
            d_input = match index {
                0 => Vec::new(),
                _ => {
                    multiply(&mut patches, view(&layer.weight).transpose(), view(&d_output));
                    scattered(&patches, layer.inputs(), CROP_SIDE >> index)
                }
            };
        }
        gradients.reverse();
        gradients
    }
}

impl Layer {
    fn inputs(&self) -> usize {
        self.weight.ncols() / TAPS
    }
}

impl Pass {
    /// Outputs of the last layer, crop by crop: row, column, channel.
    pub(crate) fn outputs(&self) -> Vec<f32> {
        let last = self.traces.iter().filter_map(|trace| Some(trace.outputs.last()?.as_slice()));
        last.collect::<Vec<_>>().concat()
    }
}

fn view(matrix: &DMatrix<f32>) -> MatRef<'_, f32> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// `a b`.
fn product(a: MatRef<'_, f32>, b: MatRef<'_, f32>) -> DMatrix<f32> {
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    multiply(&mut product, a, b);
    product
}

/// Replaces a matrix by `a b`.
fn multiply(product: &mut DMatrix<f32>, a: MatRef<'_, f32>, b: MatRef<'_, f32>) {
    for first in (0..a.ncols()).step_by(BLOCK) {
        let terms = BLOCK.min(a.ncols() - first);
        let sum = MatMut::from_column_major_slice_mut(product.as_mut_slice(), a.nrows(), b.ncols());
        let joined = if first == 0 { Accum::Replace } else { Accum::Add };
        matmul(sum, joined, a.subcols(first, terms), b.subrows(first, terms), 1.0, Par::Seq);
    }
}

/// Pixels as the first layer sees them.
fn centered(crops: &[&Crop]) -> Vec<f32> {
    let volume = CROP_SIDE * CROP_SIDE * CHANNELS;
    let mut centered = vec![0.0; crops.len() * volume];
    widest(
        #[inline(always)]
        || {
            for (centered, crop) in centered.chunks_exact_mut(volume).zip(crops) {
                for (centered, &value) in centered.iter_mut().zip(crop.0.iter()) {
                    *centered = f32::from(value) / 255.0 - PIXEL_CENTER;
                }
            }
        },
    );
    centered
}

/// Replaces outputs, position by position, by `relu(outputs + bias)`.
fn rectify(outputs: &mut [f32], bias: &[f32]) {
    widest(
        #[inline(always)]
        || {
            for position in outputs.chunks_exact_mut(bias.len()) {
                for (y, bias) in position.iter_mut().zip(bias) {
                    *y = (*y + bias).max(0.0);
                }
            }
        },
    );
}

/// Derivatives to what a ReLU was given, from those to its outputs.
fn mask(derivatives: &mut [f32], outputs: &[f32]) {
    widest(
        #[inline(always)]
        || {
            for (d, &y) in derivatives.iter_mut().zip(outputs) {
                *d = if y <= 0.0 { 0.0 } else { *d };
            }
        },
    );
}

/// Calls `with` for each run of neighbouring pixels that lies both in an image and in a row of a patch, in the patches' order: start in
/// the image, start in the patches, length; in numbers.
#[inline(always)]
fn runs(channels: usize, side: usize, images: usize, mut with: impl FnMut(usize, usize, usize)) {
    let half = side / 2;
    for position in 0..images * half * half {
        let (image, row, column) = (position / (half * half), position / half % half, position % half);
        let left = (2 * column).saturating_sub(1);
        let right = (2 * column + KERNEL - 1).min(side);
        for tap in 0..KERNEL {
            let Some(y) = (2 * row + tap).checked_sub(1).filter(|&y| y < side) else { continue };
            let skipped = left + 1 - 2 * column;
            let pixel = (image * side + y) * side + left;
            let patch = position * TAPS + tap * KERNEL + skipped;
            with(pixel * channels, patch * channels, (right - left) * channels);
        }
    }
}

/// The patches of images `[images, side, side, channels]`, zero beyond the border: `[TAPS * channels, positions]`.
fn gathered(images: &[f32], channels: usize, side: usize) -> DMatrix<f32> {
    let count = images.len() / (side * side * channels);
    let (rows, columns) = (TAPS * channels, count * side * side / 4);
    let mut patches = Vec::with_capacity(rows * columns);
    runs(channels, side, count, |pixel, slot, length| {
        patches.resize(slot, 0.0);
        // Most runs of the first layer are so short that a copy of known length is worth its own line.
        match images[pixel..].first_chunk::<{ KERNEL * CHANNELS }>() {
            Some(run) if length == run.len() => patches.extend_from_slice(run),
            _ => patches.extend_from_slice(&images[pixel..pixel + length]),
        }
    });
    patches.resize(rows * columns, 0.0);
    DMatrix::from_vec(rows, columns, patches)
}

/// The transpose of [`gathered`]: what patches hold, added up over the images.
fn scattered(patches: &DMatrix<f32>, channels: usize, side: usize) -> Vec<f32> {
    let count = patches.ncols() * 4 / (side * side);
    let mut images = vec![0.0; count * side * side * channels];
    let slots = patches.as_slice();
    widest(
        #[inline(always)]
        || {
            runs(
                channels,
                side,
                count,
                #[inline(always)]
                |pixel, slot, length| {
                    let run = &slots[slot..slot + length];
                    for (sum, value) in images[pixel..pixel + length].iter_mut().zip(run) {
                        *sum += value;
                    }
                },
            );
        },
    );
    images
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::synthetic;
    use crate::train::trunk::burn_convolution::layer;
    use burn::tensor::{Device, Tensor, TensorData};
    use vantage_dataset::{Seed, Split};

    const SIZES: [usize; 4] = [3, 5, 4, 6];

    #[test]
    fn values_and_gradients_are_those_of_burn() {
        let device = Device::flex().autodiff();
        let set = synthetic::views(Split::Train, 3, GROUP / 2, 1);
        let crops: Vec<&Crop> = set.views.iter().map(|view| &view.crop).collect();
        let mut stream = Seed(5).stream("convolution", 0);
        let mut normals = |n: usize| (0..n).map(|_| 0.2 * stream.normal() as f32).collect::<Vec<_>>();
        let layers: Vec<_> = SIZES.windows(2).map(|s| (normals(s[1] * TAPS * s[0]), normals(s[1]))).collect();
        let direction = normals(crops.len() * SIZES[3] * 16);

        let convolutions = Convolutions::new(layers.iter().cloned());
        let pass = convolutions.pass(&crops);
        let outputs = pass.outputs();
        let gradients = convolutions.backward(pass, &direction);

        let planes: Vec<f32> = crops.iter().flat_map(|crop| crop.to_chw()).collect();
        let mut x = Tensor::<4>::from_data(TensorData::new(planes, [crops.len(), 3, 32, 32]), &device) - 0.5;
        let mut parameters = Vec::new();
        for (weight, bias) in &layers {
            let shape = [bias.len(), weight.len() / bias.len()];
            let weight = TensorData::new(weight.clone(), shape);
            let weight = Tensor::<2>::from_data(weight, &device).require_grad();
            let bias = Tensor::<1>::from_data(TensorData::from(&bias[..]), &device).require_grad();
            x = layer(x, weight.clone(), bias.clone());
            parameters.push((weight, bias));
        }
        let numbers = |x: Tensor<4>| -> Vec<f32> { x.permute([0, 2, 3, 1]).try_into_vec_as().unwrap() };
        let close = |got: &[f32], expected: &[f32]| {
            let largest = expected.iter().fold(0f32, |a, b| a.max(b.abs()));
            assert!(largest > 0.0 && got.len() == expected.len());
            assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5 * largest));
        };
        close(&outputs, &numbers(x.clone()));
        let direction = TensorData::new(direction, [crops.len(), 4, 4, SIZES[3]]);
        let direction = Tensor::<4>::from_data(direction, &device).permute([0, 3, 1, 2]);
        let expected = (x * direction).sum().backward();
        for (gradient, (weight, bias)) in gradients.iter().zip(&parameters) {
            close(&gradient.weight, &weight.grad(&expected).unwrap().try_into_vec_as::<f32>().unwrap());
            close(&gradient.bias, &bias.grad(&expected).unwrap().try_into_vec_as::<f32>().unwrap());
        }
    }

    /// The bits of the committed models.
    #[test]
    #[cfg(target_arch = "x86_64")]
    fn products_are_sums_of_blocks_of_fused_multiply_adds() {
        if !std::arch::is_x86_feature_detected!("fma") {
            return println!("skipped: no FMA");
        }
        let mut stream = Seed(6).stream("products", 0);
        let mut normals = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| stream.normal() as f32);
        for (rows, inner, columns) in [(24, 48, 70), (48, 384, 33), (96, 768, 16), (24, 1040, 48)] {
            let (a, b) = (normals(rows, inner), normals(inner, columns));
            let expected = DMatrix::from_fn(rows, columns, |row, column| {
                let block = |first: usize| {
                    let terms = first..inner.min(first + BLOCK);
                    terms.fold(0f32, |sum, i| a[(row, i)].mul_add(b[(i, column)], sum))
                };
                (0..inner).step_by(BLOCK).map(block).reduce(|sum, block| sum + block).unwrap()
            });
            assert_eq!(product(view(&a), view(&b)), expected, "{rows}x{inner} by {inner}x{columns}");
            let transposed = product(view(&b).transpose(), view(&a).transpose());
            assert_eq!(transposed, expected.transpose(), "{columns}x{inner} by {inner}x{rows}");
        }
    }

    #[test]
    fn the_thread_count_changes_nothing() {
        let set = synthetic::views(Split::Train, 3, GROUP, 1);
        let crops: Vec<&Crop> = set.views.iter().map(|view| &view.crop).collect();
        let weight: Vec<f32> = (0..2 * TAPS * 3).map(|i| (i as f32).sin()).collect();
        let convolutions = Convolutions::new([(weight, vec![0.1, 0.2])].into_iter());
        let gradients = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let pass = convolutions.pass(&crops);
                let outputs = pass.outputs();
                convolutions.backward(pass, &outputs).remove(0).weight
            })
        };
        assert_eq!(gradients(1), gradients(3));
    }
}
