//! The last layer of a viewpoint-dependent model's decoder, to be learnt anew.

use crate::error::{GraphError, ModelError};
use crate::file::read;
use crate::folder::{LARGEST_FILE, matrix, narrowed, widened};
use crate::onnx::Signature;
use crate::onnx::graph::Graph;
use crate::onnx::last_layer::LastLayerGraph;
use crate::role::Role;
use crate::viewpoint_model::ViewpointModel;
use nalgebra::{DMatrix, DVector};
use std::path::Path;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{
    AnswerError, LastLayer, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    ViewpointDerivative,
};

/// A model with its decoder's last layer laid open.
pub struct DecoderLastLayer<'m> {
    model: &'m ViewpointModel,
    decoder: Part,
    jacobian: Part,
    features: Graph,
}

/// One of the graphs that the layer is in.
struct Part {
    role: Role,
    graph: LastLayerGraph,
    signature: Signature,
}

impl<'m> DecoderLastLayer<'m> {
    /// Of a model, and the folder that it was loaded from. Refused are graphs whose last layer is not one that training here writes.
    pub fn load(model: &'m ViewpointModel, folder: &Path) -> Result<Self, ModelError> {
        let part = |role| {
            let manifest = &model.folder.manifest;
            let record = manifest.graphs.get(&role).ok_or(ModelError::Absent { role })?;
            let path = folder.join(&record.file);
            let bytes = read(&path, LARGEST_FILE)?;
            let signature =
                manifest.kind.signature(role, manifest.sizes()).ok_or(ModelError::Absent { role })?;
            let graph = LastLayerGraph::find(&bytes).map_err(|source| ModelError::Graph { path, source })?;
            Ok(Part { role, graph, signature })
        };
        let (decoder, jacobian) = (part(Role::Decoder)?, part(Role::DecoderJacobian)?);
        if !jacobian.graph.has_back() || jacobian.graph.weight_value != decoder.graph.weight_value {
            let what = "a Jacobian without the weight of the decoder's last layer, or with another one, where it is to be learnt,";
            let source = GraphError::Unsupported { what: what.to_owned() };
            return Err(ModelError::Run { role: Role::DecoderJacobian, source });
        }
        let (bytes, signature) = decoder.graph.cut_off(&decoder.signature);
        let features = Graph::from_bytes(&bytes, &signature)
            .map_err(|source| ModelError::Run { role: Role::Decoder, source })?;
        Ok(Self { model, decoder, jacobian, features })
    }
}

impl Part {
    fn changed(&self, change: &DMatrix<f64>) -> Result<Graph, ModelError> {
        let role = self.role;
        Graph::from_bytes(&self.graph.exchanged(change), &self.signature)
            .map_err(|source| ModelError::Run { role, source })
    }
}

impl LastLayer for DecoderLastLayer<'_> {
    fn model(&self) -> &dyn ObservationModel {
        self.model
    }

    fn features(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(&viewpoint.conditioning())];
        let of_features = |outputs: &[&[f32]]| widened(outputs[0]).push(1.0);
        let read = self.features.read(&inputs, of_features);
        Ok(read.map_err(|source| ModelError::Run { role: Role::Decoder, source })?)
    }

    fn changed(&self, change: &DMatrix<f64>) -> Result<Box<dyn ObservationModel + '_>, AnswerError> {
        let expected = self.decoder.graph.weight_value.ncols() + 1;
        if change.shape() != (self.model.measurement_dim(), expected) {
            let (what, got) = ("change of the last layer (columns)", change.ncols());
            return Err(AnswerError::Shape { what, got, expected });
        }
        Ok(Box::new(Changed {
            model: self.model,
            decoder: self.decoder.changed(change)?,
            jacobian: self.jacobian.changed(change)?,
        }))
    }
}

/// A model with another last layer of its decoder.
struct Changed<'m> {
    model: &'m ViewpointModel,
    decoder: Graph,
    jacobian: Graph,
}

impl ObservationModel for Changed<'_> {
    fn latent_dim(&self) -> usize {
        self.model.latent_dim()
    }

    fn noise(&self) -> &MeasurementNoise {
        self.model.noise()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        self.model.encode(crop, viewpoint)
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(&viewpoint.conditioning())];
        let read = self.decoder.read(&inputs, |outputs| widened(outputs[0]));
        Ok(read.map_err(|source| ModelError::Run { role: Role::Decoder, source })?)
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(&viewpoint.conditioning())];
        let read = self.jacobian.read(&inputs, |outputs| {
            let [m, d_latent, d_conditioning] = [outputs[0], outputs[1], outputs[2]];
            Linearization {
                mean: widened(m),
                d_latent: matrix(m.len(), d_latent),
                d_viewpoint: ViewpointDerivative::new(matrix(m.len(), d_conditioning)),
            }
        });
        Ok(read.map_err(|source| ModelError::Run { role: Role::DecoderJacobian, source })?)
    }
}
