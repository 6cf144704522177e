//! What else tract computes by kernels of its own on x86-64, where those for AVX-512 round otherwise: what a processor without it
//! would take is taken everywhere, so that results have the same bits.

use std::sync::LazyLock;
use tract_onnx::prelude::DatumType;
use tract_onnx::tract_core::tract_linalg::Func;
use tract_onnx::tract_core::tract_linalg::isa::{Arch, Isa, IsaReq, native};
use tract_onnx::tract_core::tract_linalg::routines::{Routine, RoutineFactory, best_for};

/// More than any step of tract's ladder, which are at most 50.
const PREFERRED: isize = 1000;

/// The best one without AVX-512, sought once: tract asks at every node.
macro_rules! narrow {
    ($function:ident, $numbers:ident) => {{
        static BEST: LazyLock<&RoutineFactory> = LazyLock::new(|| {
            let isa = native().without(Isa::X86_64Avx512f).without(Isa::X86_64Avx512Fp16);
            let best = best_for(Func::$function, DatumType::$numbers, &isa);
            &best.expect("tract has each function in plain Rust").factory
        });
        *BEST
    }};
}

/// A routine for AVX-512.
macro_rules! submit {
    ($function:ident, $factory:expr) => {
        inventory::submit! {
            Routine {
                func: Func::$function,
                arch: Some(Arch::X86_64),
                isa: IsaReq::ANY.needing(&[Isa::X86_64Avx512f]),
                boost: PREFERRED,
                round_trip: false,
                factory: $factory,
            }
        }
    };
}

/// For each function, a routine for AVX-512 that is the best one without it.
macro_rules! without_avx512 {
    ($($numbers:ident $form:ident: $($function:ident),*;)*) => {$($(
        submit! { $function, RoutineFactory::$form(|| match narrow!($function, $numbers) {
            RoutineFactory::$form(make) => make(),
            _ => unreachable!("a function has one form"),
        }) }
    )*)*};
}

without_avx512! {
    F32 F32: Sigmoid, Tanh, Silu, Gelu, Erf, Ln, Exp, Hardswish;
    F32 F32Param: LeakyRelu;
    F32 F32Reduce: ReduceMax;
    F32 F32MapReduce: Softmax2;
    F16 F16: Sigmoid, Tanh, Silu, Gelu, Hardswish;
    F16 F16Param: LeakyRelu;
}

submit! { RmsNorm, RoutineFactory::RmsNormF32 {
    name: "generic",
    run: |row, epsilon| match narrow!(RmsNorm, F32) {
        RoutineFactory::RmsNormF32 { run, .. } => run(row, epsilon),
        _ => unreachable!("a function has one form"),
    },
} }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::onnx::kernels::choose_kernels;
    use tract_onnx::tract_core::tract_linalg::isa::IsaSet;

    #[test]
    fn no_function_is_computed_otherwise_with_avx_512() {
        choose_kernels();
        let narrow = native().without(Isa::X86_64Avx512f).without(Isa::X86_64Avx512Fp16);
        let wide = [Isa::X86_64Avx512f, Isa::X86_64Avx512Fp16, Isa::X86_64Avx512Vnni, Isa::X86_64AmxBf16];
        let wide = wide.into_iter().fold(narrow, IsaSet::with);
        for function in Func::ALL {
            for numbers in [DatumType::F32, DatumType::F16, DatumType::U8] {
                let name = |isa| best_for(function, numbers, isa).map(Routine::name);
                assert_eq!(name(&wide), name(&narrow), "{} of {numbers:?}", function.name());
            }
        }
    }
}
