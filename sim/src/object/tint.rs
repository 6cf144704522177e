//! Copies of nearly the same look.

use super::{Object, identity};
use crate::model::Model;
use crate::texture::Texture;
use std::sync::Arc;
use vantage_dataset::Stream;

impl Object {
    /// A copy whose texture is up to `tint` lighter or darker in every channel.
    pub fn tinted(&self, tint: f64, stream: &mut Stream) -> Self {
        let scale: [f64; 3] = std::array::from_fn(|_| 1.0 + stream.uniform(-tint, tint));
        let finest = self.model.texture.level(0).iter().map(|&[r, g, b, a]| {
            let [r, g, b] = [(r, scale[0]), (g, scale[1]), (b, scale[2])]
                .map(|(channel, scale)| (f64::from(channel) * scale).round().min(255.0) as u8);
            [r, g, b, a]
        });
        let texture = Texture::new(finest.collect());
        let mesh = self.model.mesh.clone();
        Self {
            id: identity(&self.family, &mesh, &texture),
            model: Arc::new(Model::new(mesh, texture)),
            ..self.clone()
        }
    }
}
