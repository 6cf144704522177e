//! `world`: surface, objects, room and light.

use crate::scene::family::Family;
use crate::scene::furniture::PieceSpec;
use crate::scene::meshes::{FixtureSpec, MeshSpec};
use crate::scene::rule::{Interval, interval_within};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;

/// What there is to see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct WorldSpec {
    /// What the objects stand on.
    #[garde(dive)]
    pub surface: SurfaceSpec,
    /// Families the objects are drawn from; every family, and every category of meshes as long as it has any left,
    /// comes up equally often, to within one.
    #[serde(default)]
    #[garde(custom(all_different), custom(not_without(&self.meshes)))]
    pub families: Vec<Family>,
    /// Objects from files, of each of which a world has one at most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[garde(dive)]
    pub meshes: Vec<MeshSpec>,
    /// Furniture from files, beside what the objects stand on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[garde(length(max = 100), dive)]
    pub fixtures: Vec<FixtureSpec>,
    /// Number of objects.
    #[garde(range(min = 1))]
    pub objects: u32,
    /// Makes all objects copies of one, each tinted by up to this in every colour channel: the same category and nearly the
    /// same look. 0 makes them equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 0.0, max = 0.5), custom(not_nan)))]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub look_alike: Option<f64>,
    /// Least gap between the circles around two objects' footprints, metres.
    #[garde(range(min = 0.0, max = 10.0), custom(not_nan))]
    pub spacing: f64,
    /// The room, centred on the world's origin; its textures change between episodes.
    #[garde(dive)]
    pub room: RoomSpec,
    /// The light, drawn anew for each episode and each session of the training views.
    #[garde(dive)]
    pub lighting: LightingSpec,
    /// Share of the drive after which the light is another one, drawn from the same ranges; the light stays where left out. Laps
    /// inside and outside of a ring are a half each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(inner(range(min = 0.0, max = 1.0), custom(not_nan)))]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub relit_at: Option<f64>,
}

/// What objects stand on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SurfaceSpec {
    /// One round table in the middle of the room.
    RoundTable {
        /// Radius of the top, metres.
        #[garde(range(min = 0.05, max = 100.0), custom(not_nan))]
        radius: f64,
        /// Height of the top, metres.
        #[garde(range(min = 0.05, max = 3.0), custom(not_nan))]
        height: f64,
    },
    /// One rectangular table in the middle of the room.
    RectangularTable {
        /// Extent of the top along x, metres.
        #[garde(range(min = 0.1, max = 200.0), custom(not_nan))]
        length: f64,
        /// Extent of the top along y, metres.
        #[garde(range(min = 0.1, max = 200.0), custom(not_nan))]
        width: f64,
        /// Height of the top, metres.
        #[garde(range(min = 0.05, max = 3.0), custom(not_nan))]
        height: f64,
    },
    /// A round pedestal for each object, spaced evenly beside the robot's path, where its camera looks.
    Pedestals {
        /// Radius of the top, metres.
        #[garde(range(min = 0.05, max = 5.0), custom(not_nan))]
        radius: f64,
        /// Height of the top, metres.
        #[garde(range(min = 0.05, max = 3.0), custom(not_nan))]
        height: f64,
        /// Distance of a pedestal's axis from the path, metres.
        #[garde(range(min = 0.1, max = 50.0), custom(not_nan))]
        offset: f64,
    },
    /// Pieces of furniture anywhere in the room; objects are dealt out to all places that have the room for them.
    Furniture(#[garde(length(min = 1, max = 500), dive)] Vec<PieceSpec>),
}

/// A rectangular room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct RoomSpec {
    /// Extent along x, metres.
    #[garde(range(min = 1.0, max = 500.0), custom(not_nan))]
    pub length: f64,
    /// Extent along y, metres.
    #[garde(range(min = 1.0, max = 500.0), custom(not_nan))]
    pub width: f64,
    /// Height of the walls, metres.
    #[garde(range(min = 1.0, max = 20.0), custom(not_nan))]
    pub height: f64,
}

/// Ranges that the light is drawn from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct LightingSpec {
    /// Ambient irradiance; 1 shows a surface at its own colour.
    #[garde(custom(interval_within(0.0, 2.0)))]
    pub ambient: Interval,
    /// Irradiance of the directional light on a surface that faces it.
    #[garde(custom(interval_within(0.0, 2.0)))]
    pub directional: Interval,
    /// Elevation of the directional light, degrees.
    #[garde(custom(interval_within(0.0, 90.0)))]
    pub elevation_deg: Interval,
    /// Each colour channel of each light is scaled by up to this much more or less.
    #[garde(range(min = 0.0, max = 0.5), custom(not_nan))]
    pub tint: f64,
}

fn not_without(meshes: &[MeshSpec]) -> impl Fn(&Vec<Family>, &()) -> garde::Result {
    move |families, ()| {
        if families.is_empty() && meshes.is_empty() {
            Err(garde::Error::new("got no family and no mesh, expected world.families or world.meshes"))
        } else {
            Ok(())
        }
    }
}

fn all_different(families: &[Family], _: &()) -> garde::Result {
    let repeated = families.iter().enumerate().find(|(i, family)| families[..*i].contains(family));
    match repeated {
        None => Ok(()),
        Some((_, family)) => Err(garde::Error::new(format!("{family:?} is listed more than once"))),
    }
}
