//! The exponential function, and what is made of it: many numbers at once on the CPU, where burn does one at a time, and again for
//! each derivative.
//!
//! Of finite numbers, values and derivatives have the bits that burn's have with glibc on x86 with FMA: both take Arm's algorithm, with
//! the error of 0.502 units in the last place that its `expf` states (optimized-routines, `math/expf.c`).

use super::rows::floats;
use burn::tensor::{Device, Tensor, activation};
use std::f64::consts::LOG2_E;
use std::sync::LazyLock;
use vantage_dataset::widest::widest;

/// Parts of an octave.
const PARTS: usize = 32;
/// `2^(r / PARTS) - 1` for `-1/2 <= r <= 1/2`, by powers of `r` from the third down to the first.
const POLYNOMIAL: [f64; 3] = {
    let step = 1.0 / PARTS as f64;
    [0.05550361559341535 * step * step * step, 0.2402284522445722 * step * step, 0.6931471806916203 * step]
};
/// Beyond these `exp` is 0 and infinite.
const RANGE: (f32, f32) = (-104.0, 89.0);
/// A sum of this size keeps no fraction: its low bits are the integer.
const SHIFT: f64 = 6_755_399_441_055_744.0;
/// Numbers that are done together.
const BATCH: usize = 16;

/// The bits of `2^(i / PARTS)`, less what `i` adds to the exponent below.
static POWERS: LazyLock<[u64; PARTS]> = LazyLock::new(|| {
    let bits = |i: usize| libm::exp2(i as f64 / PARTS as f64).to_bits() - exponent(i as u64);
    std::array::from_fn(bits)
});

/// A number of parts of an octave, with its octaves where `f64` has the exponent; by what is below them [`POWERS`] are less.
#[inline(always)]
fn exponent(parts: u64) -> u64 {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    parts << (MANTISSA - PARTS.ilog2())
}

#[inline(always)]
fn exp_batch(numbers: [f32; BATCH], powers: &[u64; PARTS]) -> [f32; BATCH] {
    let (mut parts, mut rest, mut power) = ([0; BATCH], [0.0; BATCH], [0; BATCH]);
    for i in 0..BATCH {
        let x = f64::from(numbers[i].clamp(RANGE.0, RANGE.1));
        let shifted = x.mul_add(LOG2_E * PARTS as f64, SHIFT);
        parts[i] = shifted.to_bits();
        rest[i] = x.mul_add(LOG2_E * PARTS as f64, -(shifted - SHIFT));
    }
    for i in 0..BATCH {
        power[i] = powers[parts[i] as usize % PARTS];
    }
    let [third, second, first] = POLYNOMIAL;
    let mut exponentials = [0.0; BATCH];
    for i in 0..BATCH {
        let r = rest[i];
        let high = r.mul_add(third, second);
        let low = r.mul_add(first, 1.0);
        let scale = f64::from_bits(exponent(parts[i]).wrapping_add(power[i]));
        exponentials[i] = (high.mul_add(r * r, low) * scale) as f32;
    }
    exponentials
}

/// Replaces each number `x` by `with(x, exp(of(x)))`.
#[inline(always)]
fn replace(numbers: &mut [f32], of: impl Fn(f32) -> f32, with: impl Fn(f32, f32) -> f32) {
    let powers = &*POWERS;
    widest(
        #[inline(always)]
        || {
            for numbers in numbers.chunks_mut(BATCH) {
                let mut batch = [0.0; BATCH];
                batch[..numbers.len()].copy_from_slice(numbers);
                let exponentials = exp_batch(batch.map(&of), powers);
                for i in 0..BATCH {
                    batch[i] = with(batch[i], exponentials[i]);
                }
                numbers.copy_from_slice(&batch[..numbers.len()]);
            }
        },
    );
}

/// A tensor without derivatives whose numbers were changed.
fn changed<const D: usize>(x: &Tensor<D>, change: impl FnOnce(&mut [f32])) -> Tensor<D> {
    let mut data = x.clone().detach().into_data();
    change(floats(&mut data));
    Tensor::from_data(data, &x.device())
}

fn is_on_cpu<const D: usize>(x: &Tensor<D>) -> bool {
    x.device() == Device::flex()
}

/// Zeros whose derivative to `x` is 1, where `x` is finite; elsewhere no numbers, which end a training.
fn change<const D: usize>(x: &Tensor<D>) -> Tensor<D> {
    x.clone() - x.clone().detach()
}

/// `exp(x)`.
pub(crate) fn exp<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    if !is_on_cpu(&x) {
        return x.exp();
    }
    let y = changed(&x, |numbers| replace(numbers, |x| x, |_, exp| exp));
    change(&x) * y.clone() + y
}

/// `x / (1 + exp(-x))`.
pub(crate) fn silu<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    if !is_on_cpu(&x) {
        return activation::silu(x);
    }
    let of_exp = |x: f32, exp: f32| if x >= 0.0 { 1.0 / (1.0 + exp) } else { exp / (1.0 + exp) };
    let sigmoid = changed(&x, |numbers| replace(numbers, |x| -x.abs(), of_exp));
    let rest = sigmoid.clone().neg() + 1.0;
    x.clone() * (change(&x) * rest * sigmoid.clone() + sigmoid)
}

/// The logarithm of each row's `softmax`.
pub(crate) fn log_softmax(rows: Tensor<2>) -> Tensor<2> {
    let shifted = rows.clone() - rows.detach().max_dim(1);
    shifted.clone() - exp(shifted).sum_dim(1).log()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::network::rows::numbers;
    use burn::tensor::TensorData;
    use vantage_dataset::Seed;

    /// Every so many of all numbers, with the ends of the range, infinities and no number at all among them.
    fn samples() -> Vec<f32> {
        let ends =
            [-103.97208, -103.972_07, 88.72283, 88.722_84, f32::INFINITY, -f32::INFINITY, f32::NAN, -0.0];
        (0..=u32::MAX).step_by(9973).map(f32::from_bits).chain(ends).collect()
    }

    #[test]
    fn values_are_as_exact_as_the_algorithm_states() {
        let x = samples();
        let mut exponentials = x.clone();
        replace(&mut exponentials, |x| x, |_, exp| exp);
        for (&x, y) in x.iter().zip(exponentials) {
            let exact = libm::exp(f64::from(x));
            let rounded = exact as f32;
            if x.is_nan() || rounded.is_infinite() || y.is_infinite() {
                assert_eq!(y.is_nan(), x.is_nan(), "{x}");
                assert_eq!(y.is_infinite(), rounded.is_infinite(), "{x}");
                continue;
            }
            let unit = f64::from(rounded.next_up()) - f64::from(rounded);
            assert!((f64::from(y) - exact).abs() <= 0.503 * unit, "exp({x}) = {y}");
        }
    }

    /// The bits of the committed models.
    #[test]
    #[cfg(all(target_arch = "x86_64", target_env = "gnu"))]
    fn values_are_those_of_glibc() {
        if !std::arch::is_x86_feature_detected!("fma") {
            return println!("skipped: no FMA");
        }
        let x = samples();
        let mut exponentials = x.clone();
        replace(&mut exponentials, |x| x, |_, exp| exp);
        for (&x, y) in x.iter().zip(exponentials) {
            assert!(y == x.exp() || x.is_nan(), "exp({x}) = {y}");
        }
    }

    #[test]
    #[cfg(all(target_arch = "x86_64", target_env = "gnu"))]
    fn values_and_derivatives_have_the_bits_of_burn() {
        if !std::arch::is_x86_feature_detected!("fma") {
            return println!("skipped: no FMA");
        }
        let device = Device::flex().autodiff();
        let mut stream = Seed(3).stream("exponential", 0);
        let mut normals =
            |scale: f64| -> Vec<f32> { (0..7 * 41).map(|_| (scale * stream.normal()) as f32).collect() };
        let (x, direction) = (normals(4.0), normals(1.0));
        let tensor =
            |numbers: &[f32]| Tensor::<2>::from_data(TensorData::new(numbers.to_vec(), [7, 41]), &device);
        let bits = |x: Tensor<2>| numbers(x).into_iter().map(f32::to_bits).collect::<Vec<_>>();
        let value_and_gradient = |of: fn(Tensor<2>) -> Tensor<2>| {
            let x = tensor(&x).require_grad();
            assert!(is_on_cpu(&x));
            let y = of(x.clone());
            let gradients = (y.clone() * tensor(&direction)).sum().backward();
            (bits(y), bits(x.grad(&gradients).unwrap()))
        };
        type Function = fn(Tensor<2>) -> Tensor<2>;
        let pairs: [(Function, Function); 3] = [
            (exp, |x| x.exp()),
            (silu, |x| activation::silu(x)),
            (log_softmax, |x| activation::log_softmax(x, 1)),
        ];
        for (ours, burns) in pairs {
            assert_eq!(value_and_gradient(ours), value_and_gradient(burns));
        }
    }
}
