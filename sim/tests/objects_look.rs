//! Objects look as their symmetry says: the same after a turn of it, different after any other; and instances differ.

use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Camera, Pose, Seed, Split, Symmetry};
use vantage_sim::object::Object;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::scene::Family;

const SIDE: u32 = 32;
const INSTANCES: u64 = 6;
const ELEVATION: f64 = 0.5;

fn objects(family: Family) -> impl Iterator<Item = Object> {
    (0..INSTANCES).map(move |index| Object::generate(family, Split::Test, Seed(21), index))
}

/// The object from a camera at `azimuth`, in shadowless light, so that only shape and texture are seen.
fn view(object: &Object, azimuth: f64) -> Vec<u8> {
    let distance = 5.0 * object.size;
    let (sin, cos) = ELEVATION.sin_cos();
    let eye = distance * Vector3::new(cos * azimuth.cos(), cos * azimuth.sin(), sin);
    let scene = RenderScene {
        placements: vec![Placement {
            model: object.model.clone(),
            world_from_model: Pose::identity(),
            id: 1,
        }],
        light: Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] },
        background: [0; 3],
    };
    let camera = Camera::with_horizontal_fov(SIDE, SIDE, 2.0 * (0.5 * object.size / distance).atan());
    let world_from_camera = Pose::face_towards(&Point3::from(eye), &Point3::origin(), &-Vector3::z());
    ReferenceRenderer::new()
        .frame(&scene, &Shot { camera, world_from_camera })
        .expect("the reference renderer draws it")
        .rgb
}

/// Mean absolute difference over the pixels that either covers, levels of 255.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    let covered = a.chunks_exact(3).zip(b.chunks_exact(3)).filter(|(p, q)| p != &[0; 3] || q != &[0; 3]);
    let (sum, count) = covered.fold((0.0, 0.0), |(sum, count), (p, q)| {
        let step: f64 = p.iter().zip(q).map(|(x, y)| f64::from(x.abs_diff(*y))).sum();
        (sum + step / 3.0, count + 1.0)
    });
    sum / count
}

#[test]
fn a_turn_of_the_symmetry_changes_nothing() {
    for family in Family::ALL {
        let turns: &[f64] = match family.symmetry() {
            Symmetry::None => continue,
            Symmetry::Cyclic { order } => &[2.0 * PI / f64::from(order), 4.0 * PI / f64::from(order)],
            Symmetry::Revolution => &[0.3, 1.0, 2.5],
        };
        for object in objects(family) {
            for azimuth in [0.0, 0.6] {
                for turn in turns {
                    let change = difference(&view(&object, azimuth), &view(&object, azimuth + turn));
                    assert!(change < 6.0, "{} {azimuth} + {turn}: {change}", family.name());
                }
            }
        }
    }
}

#[test]
fn any_other_turn_changes_the_look() {
    for family in Family::ALL {
        let turns = match family.symmetry() {
            Symmetry::None => vec![0.25 * PI, 0.5 * PI, 0.75 * PI, PI],
            Symmetry::Cyclic { order } => vec![PI / f64::from(order)],
            Symmetry::Revolution => continue,
        };
        for object in objects(family) {
            for step in 0..8 {
                let azimuth = 0.1 + 0.25 * PI * f64::from(step);
                for turn in &turns {
                    let change = difference(&view(&object, azimuth), &view(&object, azimuth + turn));
                    assert!(change > 12.0, "{} {azimuth} + {turn}: {change}", family.name());
                }
            }
        }
    }
}

#[test]
fn instances_of_a_family_look_different() {
    for family in Family::ALL {
        let views: Vec<Vec<u8>> = objects(family).map(|object| view(&object, 0.5)).collect();
        for (i, a) in views.iter().enumerate() {
            for b in &views[..i] {
                let change = difference(a, b);
                assert!(change > 20.0, "two of {}: {change}", family.name());
            }
        }
    }
}
