//! Which of tract's kernels multiply matrices on x86-64: the same on every processor that has AVX2.

use tract_onnx::prelude::DatumType;
use tract_onnx::tract_core::tract_linalg::isa::{Arch, Isa, native};
use tract_onnx::tract_core::tract_linalg::knobs::TRACT_CPU_ISA;
use tract_onnx::tract_core::tract_linalg::mmm_tiers::MmmTier;

/// Name, rows and columns of its tiles, and how long it takes for a number of a full tile, relative to the first (measured on
/// an AMD EPYC of the generation Zen 5).
const KERNELS: [(&str, usize, usize, f32); 3] =
    [("fma_mmm_f32_24x4", 24, 4, 1.0), ("fma_mmm_f32_16x6", 16, 6, 0.98), ("fma_mmm_f32_8x8", 8, 8, 1.14)];

/// How much longer the first kernel may take than another: products of one matrix with several share its packing where they
/// share the kernel.
const PATIENCE: f32 = 1.1;

inventory::submit! {
    MmmTier {
        arch: Some(Arch::X86_64),
        // Beyond those of tract, which ask for the vendor of the processor.
        precedence: 100,
        name: "vantage",
        applies: |isa| isa.has(Isa::X86_64Avx2) && isa.has(Isa::X86_64Fma),
        preferred: |_, number, query, _| match (number, query.m, query.n) {
            (DatumType::F32, Some(rows), Some(columns)) => kernel(rows, columns),
            _ => None,
        },
    }
}

/// For a product of so many rows and columns; `None` for a few columns, of which tract has kernels of their own.
fn kernel(rows: usize, columns: usize) -> Option<&'static str> {
    let cost = |&(_, height, width, cost): &(&str, usize, usize, f32)| {
        cost * rows.next_multiple_of(height) as f32 * columns.next_multiple_of(width) as f32
    };
    let first = &KERNELS[0];
    let best = KERNELS.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
    let chosen = if cost(first) <= PATIENCE * cost(best) { first } else { best };
    (columns >= 6).then_some(chosen.0)
}

/// Leaves out the kernels for AVX-512, which round otherwise than those for AVX2, so that results would depend on the processor. They are
/// slower on some processors, and faster on others. What the environment says of them does not count.
pub(super) fn choose_kernels() -> Result<(), String> {
    TRACT_CPU_ISA.set(Some("-avx512f".into()));
    match native().has(Isa::X86_64Avx512f) {
        true => Err("it chose kernels for AVX-512 before a model was loaded".into()),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tract_onnx::tract_core::tract_linalg::MmmDispatch;
    use tract_onnx::tract_core::tract_linalg::mmm::Query;

    #[test]
    fn tract_takes_the_kernels_that_are_chosen_here() {
        choose_kernels().unwrap();
        if !(native().has(Isa::X86_64Avx2) && native().has(Isa::X86_64Fma)) {
            println!("skipped: no AVX2");
            return;
        }
        let dispatch = MmmDispatch::native();
        for (rows, columns, expected) in [
            (256, 32, Some("fma_mmm_f32_24x4")),
            (34, 32, Some("fma_mmm_f32_24x4")),
            (128, 64, Some("fma_mmm_f32_16x6")),
            (8, 8, Some("fma_mmm_f32_8x8")),
            (256, 1, None),
            (256, 2, None),
        ] {
            let query = Query::plain(DatumType::F32, Some(rows), Some(256), Some(columns));
            let suitable = dispatch.suitable(&query);
            let (taken, ..) = dispatch.preferred(&query, &suitable).unwrap();
            assert_eq!(kernel(rows, columns), expected, "{rows} x {columns}");
            assert_eq!(expected.is_some(), Some(taken.name()) == expected, "{}", taken.name());
        }
    }
}
