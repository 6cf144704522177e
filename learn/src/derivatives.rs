//! Whether a graph of derivatives has those of the graph that it belongs to.

use crate::canary::CanaryCase;
use crate::difference::central_differences;
use crate::error::ModelError;
use crate::onnx::graph::Graph;
use crate::role::Role;
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest distance from central differences, relative to these in the Frobenius norm: where a network has kinks, differences are some
/// percent off.
const TOLERANCE: f64 = 0.1;

/// Root mean square below which derivatives count as small, and only a distance beyond a tenth of this as one.
const SMALL: f64 = 1e-3;

/// The graph that a role has the derivatives of.
fn primal(role: Role) -> Option<Role> {
    match role {
        Role::DecoderJacobian => Some(Role::Decoder),
        Role::PredictorJacobian => Some(Role::Predictor),
        _ => None,
    }
}

/// Compares the outputs of a Jacobian's graph in `path`, on the inputs of a case, with what its primal gives there and around; nothing for
/// other roles.
pub(crate) fn check_derivatives(
    graphs: &BTreeMap<Role, Graph>,
    case: &CanaryCase,
    path: &Path,
) -> Result<(), ModelError> {
    let Some(of) = primal(case.role) else { return Ok(()) };
    let (Some(jacobian), Some(primal)) = (graphs.get(&case.role), graphs.get(&of)) else { return Ok(()) };
    let run = |graph: &Graph, role, inputs: &[Vec<f32>]| {
        let inputs: Vec<_> = inputs.iter().map(Vec::as_slice).collect();
        graph.run(&inputs).map_err(|source| ModelError::Run { role, source })
    };
    let predicted = |inputs: &[Vec<f32>]| {
        let [predicted] = run(primal, of, inputs)?.try_into().expect("one output");
        Ok(DMatrix::from_iterator(predicted.len(), 1, predicted.into_iter().map(f64::from)))
    };
    let mut expected = vec![predicted(&case.inputs)?];
    for index in 0..case.inputs.len() {
        let at: Vec<_> = case.inputs[index].iter().copied().map(f64::from).collect();
        expected.push(central_differences(&at, |moved| {
            let mut inputs = case.inputs.clone();
            inputs[index] = moved.iter().map(|&number| number as f32).collect();
            Ok(predicted(&inputs)?.column(0).into_owned())
        })?);
    }
    let names = jacobian.signature().outputs.iter().map(|output| &output.name);
    for ((got, expected), output) in run(jacobian, case.role, &case.inputs)?.iter().zip(&expected).zip(names)
    {
        let columns = expected.ncols();
        let got = DMatrix::from_row_iterator(expected.nrows(), columns, got.iter().copied().map(f64::from));
        let scale = expected.norm().max(SMALL * (got.len() as f64).sqrt());
        let distance = (got - expected).norm() / scale;
        if distance > TOLERANCE {
            let (path, output) = (path.to_owned(), output.clone());
            return Err(ModelError::Derivatives { path, output, of, got: distance, limit: TOLERANCE });
        }
    }
    Ok(())
}
