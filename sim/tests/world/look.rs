//! A training view and a detection of the same object from the same viewpoint look alike.

use crate::scene::{checked, even_light, shipped};
use crate::views::make;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Camera, Crop, Pose, Seed, Split, Viewpoint};
use vantage_sim::object::Object;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::robot::mount::looking;
use vantage_sim::scene::DetectorSpec;
use vantage_sim::sensor::detector::{Target, detect};

/// A camera that sees the object in the middle of its image from this viewpoint.
fn object_from_camera(viewpoint: &Viewpoint, size: f64) -> Pose {
    let distance = viewpoint.log_distance.exp() * size;
    let level = looking(viewpoint.azimuth() + PI, -viewpoint.elevation());
    Pose::from_parts(
        Translation3::from(viewpoint.direction * distance),
        level * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -viewpoint.roll),
    )
}

fn detection_crop(object: &Object, viewpoint: &Viewpoint, camera: Camera) -> Crop {
    let light = Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
    let placement = Placement { model: Arc::clone(&object.model), world_from_model: Pose::identity(), id: 1 };
    let scene = RenderScene { placements: vec![placement], light, background: [90; 3] };
    let target = Target {
        world_from_object: Pose::identity(),
        half_extents: object.half_extents,
        alone: scene.clone(),
    };
    let shot = Shot { camera, world_from_camera: object_from_camera(viewpoint, object.size) };
    let mut renderer = ReferenceRenderer::default();
    let frame = renderer.frame(&scene, &shot).unwrap();
    let spec =
        DetectorSpec { min_visible_fraction: 0.5, min_mask_pixels: 10, faults: None, depth_sigma: None };
    let mut seen = detect(&spec, &[target], 0, &shot, &frame, &mut renderer, Seed(0)).unwrap();
    seen.remove(0).0.masked_crop
}

fn difference(a: &Crop, b: &Crop) -> f64 {
    let sum: f64 = a.0.iter().zip(b.0.iter()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / a.0.len() as f64
}

#[test]
fn training_views_look_like_detections_of_the_same_viewpoint() {
    let mut spec = shipped("tabletop");
    spec.world.lighting = even_light();
    spec.views.views_per_instance = 6;
    spec.views.occluder_probability = 0.0;
    let conditions = checked(spec).view_conditions();
    let camera = conditions.camera.intrinsics();
    let set = make(&conditions, Split::Train, 16, 9);
    let seed = Seed(9).child("train", 0);
    let (mut same, mut turned) = (0.0, 0.0);
    for view in &set.views {
        let family = conditions.families[view.instance % conditions.families.len()];
        let object = Object::generate(family, Split::Train, seed, view.instance as u64);
        assert_eq!(object.id, set.instances[view.instance].id);
        same += difference(&view.crop, &detection_crop(&object, &view.viewpoint, camera));
        turned += difference(&view.crop, &detection_crop(&object, &view.viewpoint.turned(0.5), camera));
    }
    let views = set.views.len() as f64;
    let (same, turned) = (same / views, turned / views);
    println!("same viewpoint {same:.2} of 255, turned by half a radian {turned:.2}");
    assert!(same < 8.0, "views differ from detections by {same} of 255 on average");
    assert!(turned > 2.0 * same, "same viewpoint {same}, turned by half a radian {turned}");
}
