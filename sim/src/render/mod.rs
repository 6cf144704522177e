//! Rendering: `z_k` before the detector.
//!
//! Two renderers stand behind [`Renderer`]: [`mod@wgpu`] on any Vulkan driver (lavapipe on a machine without a GPU), and a
//! plain-Rust [`mod@reference`] rasterizer that gives the same bits on any CPU and is the oracle of the other.
//!
//! Both draw the same picture: triangles counter-clockwise on the image, nearest first (earlier placement on a tie), from
//! [`NEAR`] to infinity; albedo filtered bilinearly, in sRGB encoding with repeating coordinates, at the mip level whose
//! texels are nearest in size to the pixel's footprint; `n . l` interpolated from the corners; sums in linear light; one
//! sample at each pixel's centre.

mod bounds;
mod candidates;
pub mod choice;
mod projection;
pub mod reference;
mod view;
pub mod wgpu;

use crate::model::Model;
use crate::scene::MAX_SIDE;
use nalgebra::Vector3;
use std::sync::Arc;
use vantage_dataset::{Camera, Pose};

/// The id of a pixel on which nothing was drawn.
pub const NO_OBJECT: u32 = 0;

/// Distance of the near plane along the optical axis, metres.
pub const NEAR: f64 = 0.01;

/// A model placed in the world.
#[derive(Clone, Debug)]
pub struct Placement {
    /// What to draw.
    pub model: Arc<Model>,
    /// Where.
    pub world_from_model: Pose,
    /// Value written to the id target, below `u32::MAX`; [`NO_OBJECT`] for surroundings.
    pub id: u32,
}

/// A directional light and an ambient term, in linear light: `albedo * (ambient + diffuse * max(0, n . l))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the light, world frame.
    pub direction: Vector3<f64>,
    /// Ambient irradiance, linear RGB.
    pub ambient: [f32; 3],
    /// Irradiance of the directional light, linear RGB.
    pub diffuse: [f32; 3],
}

/// Everything that is drawn.
#[derive(Clone, Debug)]
pub struct RenderScene {
    /// The models.
    pub placements: Vec<Placement>,
    /// The light.
    pub light: Light,
    /// sRGB colour where nothing is drawn.
    pub background: [u8; 3],
}

/// A camera in the world.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Intrinsics.
    pub camera: Camera,
    /// Extrinsics: OpenCV camera frame.
    pub world_from_camera: Pose,
}

impl Shot {
    fn check(&self) -> Result<(), RenderError> {
        let Camera { width, height, fx, fy, cx, cy } = self.camera;
        let sides = 1..=MAX_SIDE;
        let pose = self.world_from_camera.to_homogeneous();
        let sound = sides.contains(&width)
            && sides.contains(&height)
            && fx > 0.0
            && fy > 0.0
            && [fx, fy, cx, cy].iter().chain(pose.iter()).all(|number| number.is_finite());
        if sound { Ok(()) } else { Err(RenderError::Shot { width, height, fx, fy, cx, cy }) }
    }
}

/// A rendered image; all buffers row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB, 3 bytes a pixel.
    pub rgb: Vec<u8>,
    /// Distance along the optical axis, metres; infinite where nothing was drawn.
    pub depth: Vec<f32>,
    /// Id of the nearest placement.
    pub ids: Vec<u32>,
}

/// A square part of an image, rendered at its own resolution.
#[derive(Clone, Copy, Debug)]
pub struct TileShot<'a> {
    /// What is drawn.
    pub scene: &'a RenderScene,
    /// The image of which the tile is a part.
    pub shot: Shot,
    /// Centre of the part, pixels of the shot (may lie outside the image).
    pub center: [f64; 2],
    /// Side of the part, pixels of the shot.
    pub side: f64,
    /// The id whose pixels are counted without occluders.
    pub target: u32,
}

impl TileShot<'_> {
    /// The shot whose image of `side * side` pixels is this part.
    pub fn window(&self, side: u32) -> Shot {
        let scale = f64::from(side) / self.side;
        let camera = Camera {
            width: side,
            height: side,
            fx: self.shot.camera.fx * scale,
            fy: self.shot.camera.fy * scale,
            cx: (self.shot.camera.cx - self.center[0] + self.side / 2.0) * scale,
            cy: (self.shot.camera.cy - self.center[1] + self.side / 2.0) * scale,
        };
        Shot { camera, world_from_camera: self.shot.world_from_camera }
    }
}

/// A rendered part of an image; buffers row-major, `side * side` pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Pixels along each side.
    pub side: u32,
    /// sRGB, 3 bytes a pixel.
    pub rgb: Vec<u8>,
    /// Id of the nearest placement.
    pub ids: Vec<u32>,
    /// Pixels of the target if nothing else were there (amodal).
    pub amodal_pixels: u32,
}

/// What draws, for manifests.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RendererInfo {
    /// `wgpu` or `reference`.
    pub renderer: String,
    /// Adapter name, or `cpu`.
    pub adapter: String,
    /// Driver name and version, empty for the reference.
    pub driver: String,
}

/// A renderer.
pub trait Renderer: Send {
    /// What it is and runs on.
    fn info(&self) -> RendererInfo;

    /// Renders one image.
    fn frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError>;

    /// Renders tiles of `side * side` pixels, in the order given.
    fn tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError>;
}

/// Why rendering failed.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum RenderError {
    /// No Vulkan driver was found.
    #[error(
        "no Vulkan adapter found ({detail}); install a driver, for example `apt-get install mesa-vulkan-drivers` \
         for lavapipe, or use `--renderer reference`"
    )]
    NoAdapter { detail: String },
    /// The camera cannot take an image.
    #[error(
        "cannot render {width}x{height} pixels with fx {fx}, fy {fy}, cx {cx}, cy {cy}: expected sides of 1 to {MAX_SIDE} \
         pixels, positive focal lengths, and finite numbers in intrinsics and pose"
    )]
    Shot { width: u32, height: u32, fx: f64, fy: f64, cx: f64, cy: f64 },
    /// The device failed while rendering.
    #[error("the graphics device `{adapter}` failed: {detail}")]
    Device { adapter: String, detail: String },
}
