//! Which of tract's kernels multiply matrices on x86-64. All that are named here add the products that make one number of the
//! result in the same order, fused, so that it has the same bits whichever are taken; `avx512_mmm_f32_16x1` adds them in four sums.

use tract_onnx::prelude::DatumType;
use tract_onnx::tract_core::tract_linalg::isa::{Arch, Isa, IsaSet};
use tract_onnx::tract_core::tract_linalg::knobs::TRACT_CPU_ISA;
use tract_onnx::tract_core::tract_linalg::mmm_tiers::MmmTier;

struct Kernel {
    name: &'static str,
    /// Rows and columns of its tiles.
    tile: [usize; 2],
    /// How long it takes for a number of a full tile, relative to the second kernel (measured on an AMD EPYC of the generation Zen 5).
    cost: f32,
}

const fn kernel(name: &'static str, tile: [usize; 2], cost: f32) -> Kernel {
    Kernel { name, tile, cost }
}

/// The first needs AVX-512.
const KERNELS: [Kernel; 8] = [
    kernel("avx512_mmm_f32_48x4", [48, 4], 0.6),
    kernel("fma_mmm_f32_24x4", [24, 4], 1.0),
    kernel("fma_mmm_f32_16x6", [16, 6], 0.98),
    kernel("fma_mmm_f32_8x8", [8, 8], 1.14),
    kernel("fma_mmm_f32_32x3", [32, 3], 1.05),
    kernel("fma_mmm_f32_40x2", [40, 2], 1.1),
    kernel("fma_mmm_f32_64x1", [64, 1], 1.6),
    kernel("fma_mmm_f32_32x1", [32, 1], 2.1),
];

/// How much longer the first kernel may take than another: products of one matrix with several share its packing where their
/// kernels have as many columns.
const PATIENCE: f32 = 1.1;

inventory::submit! {
    MmmTier {
        arch: Some(Arch::X86_64),
        // Beyond those of tract, which ask for the vendor of the processor.
        precedence: 100,
        name: "vantage",
        applies: |isa| isa.has(Isa::X86_64Avx2) && isa.has(Isa::X86_64Fma) && isa.has(Isa::X86_64F16c),
        preferred: |isa, number, query, _| match (number, query.m, query.n) {
            (DatumType::F32, Some(rows), Some(columns)) => Some(fastest(isa, rows, columns)),
            _ => None,
        },
    }
}

/// For a product of so many rows and columns.
fn fastest(isa: &IsaSet, rows: usize, columns: usize) -> &'static str {
    let known = &KERNELS[usize::from(!isa.has(Isa::X86_64Avx512f))..];
    let cost = |&Kernel { tile: [height, width], cost, .. }: &Kernel| {
        cost * rows.next_multiple_of(height) as f32 * columns.next_multiple_of(width) as f32
    };
    let first = &known[0];
    let least = known.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(first);
    if cost(first) <= PATIENCE * cost(least) { first.name } else { least.name }
}

/// Lets tract use AVX-512 where it is fast: on processors that also have AVX-VNNI, which newer ones have, as a rule with units of
/// full width. What the environment says of instructions does not count. Where tract has chosen before, only speed differs.
pub(super) fn choose_kernels() {
    let fast = std::arch::is_x86_feature_detected!("avxvnni");
    TRACT_CPU_ISA.set(Some(if fast { "-avx512fp16" } else { "-avx512f,-avx512fp16" }.into()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use tract_onnx::tract_core::tract_linalg::mmm::Query;
    use tract_onnx::tract_core::tract_linalg::{MmmDispatch, isa};

    fn avx2() -> IsaSet {
        [Isa::X86_64Avx, Isa::X86_64Avx2, Isa::X86_64Fma, Isa::X86_64F16c]
            .into_iter()
            .fold(IsaSet::of_arch(Arch::X86_64), IsaSet::with)
    }

    #[test]
    fn tract_takes_the_kernels_that_are_chosen_here() {
        for (rows, columns, narrow, wide) in [
            (256, 32, "fma_mmm_f32_24x4", "avx512_mmm_f32_48x4"),
            (34, 32, "fma_mmm_f32_24x4", "avx512_mmm_f32_48x4"),
            (24, 256, "fma_mmm_f32_24x4", "fma_mmm_f32_24x4"),
            (128, 64, "fma_mmm_f32_16x6", "avx512_mmm_f32_48x4"),
            (8, 8, "fma_mmm_f32_8x8", "fma_mmm_f32_8x8"),
            (256, 1, "fma_mmm_f32_64x1", "fma_mmm_f32_64x1"),
            (96, 1, "fma_mmm_f32_32x1", "fma_mmm_f32_32x1"),
            (40, 2, "fma_mmm_f32_40x2", "fma_mmm_f32_40x2"),
            (64, 3, "fma_mmm_f32_32x3", "fma_mmm_f32_32x3"),
        ] {
            for (isa, expected) in [(avx2(), narrow), (avx2().with(Isa::X86_64Avx512f), wide)] {
                assert_eq!(fastest(&isa, rows, columns), expected, "{rows} x {columns}");
                let dispatch = MmmDispatch::for_isa(isa);
                let query = Query::plain(DatumType::F32, Some(rows), Some(256), Some(columns));
                let suitable = dispatch.suitable(&query);
                let (taken, ..) = dispatch.preferred(&query, &suitable).unwrap();
                assert_eq!(taken.name(), expected);
            }
        }
    }

    #[cfg(feature = "train")]
    #[test]
    fn products_are_summed_in_order_and_fused_to_the_bit() {
        use crate::onnx::build::GraphBuilder;
        use crate::onnx::graph::Graph;
        use crate::onnx::{Signature, TensorSpec};

        const INNER: usize = 77;
        choose_kernels();
        if !avx2().iter().all(|isa| isa::native().has(isa)) {
            return println!("skipped: no AVX2 with fused products");
        }
        for (rows, columns) in
            [(1, 96), (1, 256), (2, 40), (3, 64), (4, 7), (5, 24), (9, 20), (16, 130), (32, 256), (50, 34)]
        {
            let numbers = |count: usize, scale: f64| {
                (0..count).map(|i| libm::sin(scale * (i + 1) as f64) as f32).collect::<Vec<_>>()
            };
            let (left, right) = (numbers(rows * INNER, 1.7), numbers(INNER * columns, 0.9));
            let spec = |name, shape| vec![TensorSpec::new(name, shape)];
            let signature =
                Signature { inputs: spec("left", &[rows, INNER]), outputs: spec("out", &[rows, columns]) };
            let mut builder = GraphBuilder::new("product", &signature);
            builder.weight("right", &[INNER, columns], &right);
            builder.node("MatMul", &["left", "right"], "out");
            let got = Graph::from_bytes(&builder.finish(), &signature).unwrap().run(&[&left]).unwrap();
            for (index, number) in got[0].iter().enumerate() {
                let (row, column) = (index / columns, index % columns);
                let factors = (0..INNER).map(|i| (left[row * INNER + i], right[i * columns + column]));
                let expected = factors.fold(0.0f32, |sum, (a, b)| a.mul_add(b, sum));
                assert_eq!(number.to_bits(), expected.to_bits(), "{rows} x {columns}, {row} {column}");
            }
        }
    }
}
