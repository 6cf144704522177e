//! The last layer of a decoder's graph, where it is one that training here writes: cut off, and exchanged.

use super::check::numbers;
use super::error::GraphError;
use super::{Signature, TensorSpec};
use nalgebra::{DMatrix, DVector};
use prost::Message;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::Dimension;
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Size;
use tract_onnx::pb::type_proto::{Tensor, Value};
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto, TensorProto, TensorShapeProto, TypeProto};

/// The output of the layer, in a decoder's graph and in that of its Jacobian.
const OUTPUT: &str = "measurement";
/// The weight once more, `[M x F]`, where derivatives are carried back.
const BACK: &str = "back.head";

/// A graph with a last layer `W f + b`.
pub(crate) struct LastLayerGraph {
    model: ModelProto,
    /// Name of `W^T`, `[F x M]`.
    weight: String,
    /// Name of `b`, `[M]`.
    bias: String,
    /// Name of `f`, `[1 x F]`.
    input: String,
    /// `[M x F]`.
    pub(crate) weight_value: DMatrix<f64>,
    bias_value: DVector<f64>,
    /// Name of the weight once more.
    back: Option<String>,
}

impl LastLayerGraph {
    /// Finds the layer in a graph that was checked before.
    pub(crate) fn find(bytes: &[u8]) -> Result<Self, GraphError> {
        let malformed = |error: prost::DecodeError| GraphError::Malformed {
            bytes: bytes.len(),
            reason: error.to_string(),
        };
        let model = ModelProto::decode(bytes).map_err(malformed)?;
        let graph = model.graph.as_ref();
        Self::in_graph(graph.unwrap_or(&GraphProto::default()), &model).ok_or_else(|| GraphError::Unsupported {
            what: format!("a last layer that is no Gemm of a weight and a bias to {OUTPUT:?}, where it is to be learnt,"),
        })
    }

    fn in_graph(graph: &GraphProto, model: &ModelProto) -> Option<Self> {
        let layer = made_by(graph, OUTPUT).filter(|node| node.op_type == "Gemm")?;
        let [input, weight, bias] = layer.input.as_slice() else { return None };
        if !layer.attribute.is_empty() {
            return None;
        }
        let (weight, bias) = (stored(graph, weight)?, stored(graph, bias)?);
        let (&[inputs, outputs], &[of_bias]) = (weight.dims.as_slice(), bias.dims.as_slice()) else {
            return None;
        };
        let [rows, columns] = [outputs, inputs].map(|size| usize::try_from(size).ok());
        let (rows, columns) = (rows?, columns?);
        // Row-major `[F x M]` is column-major `[M x F]`.
        let wide = |tensor: &TensorProto| numbers(tensor).into_iter().map(f64::from).collect::<Vec<_>>();
        let weight_value =
            DMatrix::from_vec(rows, columns, Some(wide(weight)).filter(|w| w.len() == rows * columns)?);
        let bias_value =
            DVector::from_vec(Some(wide(bias)).filter(|b| b.len() == rows && of_bias == outputs)?);
        let back = match stored(graph, BACK) {
            None => None,
            Some(back) => {
                let numbers = Some(wide(back)).filter(|numbers| numbers.len() == rows * columns)?;
                // Anything else would not be the layer's derivative.
                (DMatrix::from_row_slice(rows, columns, &numbers) == weight_value).then(|| back.name.clone())
            }
        };
        Some(Self {
            model: model.clone(),
            weight: weight.name.clone(),
            bias: bias.name.clone(),
            input: input.clone(),
            weight_value,
            bias_value,
            back,
        })
    }

    /// Whether the weight is there once more, where derivatives are carried back.
    pub(crate) fn has_back(&self) -> bool {
        self.back.is_some()
    }

    /// The graph that ends where the layer begins, and its signature.
    pub(crate) fn cut_off(&self, signature: &Signature) -> (Vec<u8>, Signature) {
        let mut model = self.model.clone();
        let features = TensorSpec::new(&self.input, &[1, self.weight_value.ncols()]);
        if let Some(graph) = &mut model.graph {
            graph.node.retain(|node| !node.output.iter().any(|output| output == OUTPUT));
            graph.output.truncate(1);
            for output in &mut graph.output {
                output.name.clone_from(&features.name);
                output.r#type = Some(of_shape(&features.shape));
            }
        }
        (model.encode_to_vec(), Signature { inputs: signature.inputs.clone(), outputs: vec![features] })
    }

    /// The graph with `[W b] + change` in place of `[W b]`, `[M x F + 1]`.
    pub(crate) fn exchanged(&self, change: &DMatrix<f64>) -> Vec<u8> {
        let features = self.weight_value.ncols();
        let weight = &self.weight_value + change.columns(0, features);
        let bias = &self.bias_value + change.column(features);
        let mut model = self.model.clone();
        let weights = model.graph.iter_mut().flat_map(|graph| &mut graph.initializer);
        for tensor in weights {
            let exchanged: Vec<f64> = match &tensor.name {
                name if *name == self.weight => weight.iter().copied().collect(),
                name if *name == self.bias => bias.iter().copied().collect(),
                name if Some(name) == self.back.as_ref() => weight.transpose().iter().copied().collect(),
                _ => continue,
            };
            tensor.data_type = DataType::Float as i32;
            tensor.raw_data = exchanged.iter().flat_map(|&number| (number as f32).to_le_bytes()).collect();
        }
        model.encode_to_vec()
    }
}

fn made_by<'g>(graph: &'g GraphProto, tensor: &str) -> Option<&'g NodeProto> {
    graph.node.iter().find(|node| node.output.iter().any(|output| output == tensor))
}

/// The weight of a name, or the one that a Cast to single precision makes it of.
fn stored<'g>(graph: &'g GraphProto, name: &str) -> Option<&'g TensorProto> {
    let of = match made_by(graph, name) {
        Some(cast) if cast.op_type == "Cast" => cast.input.first()?,
        Some(_) => return None,
        None => name,
    };
    graph.initializer.iter().find(|weight| weight.name == *of)
}

fn of_shape(shape: &[usize]) -> TypeProto {
    let size = |&size: &usize| Dimension { value: Some(Size::DimValue(size as i64)), ..Dimension::default() };
    let shape = TensorShapeProto { dim: shape.iter().map(size).collect() };
    let tensor = Tensor { elem_type: DataType::Float as i32, shape: Some(shape) };
    TypeProto { value: Some(Value::TensorType(tensor)), ..TypeProto::default() }
}
