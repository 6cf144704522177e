//! Views of painted cylinders: enough to learn a viewpoint from, and made in microseconds.

use nalgebra::Vector3;
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::views::InstanceRecord;
use vantage_dataset::{Crop, InstanceId, Seed, Split, Stream, Symmetry, View, ViewSet, Viewpoint};

/// `instances` cylinders, each seen `views` times; instances of different splits or seeds differ.
pub fn views(split: Split, instances: usize, views: usize, seed: u64) -> ViewSet {
    let seed = Seed(seed).child(split.name(), 0);
    let mut set = ViewSet { split, instances: Vec::new(), views: Vec::new() };
    for instance in 0..instances {
        let mut stream = seed.stream("instance", instance as u64);
        let id = InstanceId(seed.child("id", instance as u64).0);
        set.instances.push(InstanceRecord { id, family: "cylinder".into(), symmetry: Symmetry::None });
        let paint = Paint::draw(&mut stream);
        for _ in 0..views {
            let viewpoint = viewpoint(&mut stream);
            let crop = paint.seen_from(&viewpoint);
            set.views.push(View {
                instance,
                session: 0,
                viewpoint,
                crop,
                visible_fraction: 1.0,
                box_center_error: [0.0; 2],
                sighting: None,
            });
        }
    }
    set
}

fn viewpoint(stream: &mut Stream) -> Viewpoint {
    let azimuth = stream.uniform(-std::f64::consts::PI, std::f64::consts::PI);
    let elevation = stream.uniform(0.0, 0.8);
    Viewpoint {
        direction: Vector3::new(
            elevation.cos() * azimuth.cos(),
            elevation.cos() * azimuth.sin(),
            elevation.sin(),
        ),
        roll: stream.uniform(-0.1, 0.1),
        log_distance: stream.uniform(0.8, 1.4),
    }
}

/// A ground colour, and a band of another colour around azimuth 0.
struct Paint {
    ground: [f64; 3],
    band: [f64; 3],
    width: f64,
}

impl Paint {
    fn draw(stream: &mut Stream) -> Self {
        let mut color = || [(); 3].map(|()| stream.uniform(0.1, 0.9));
        let (ground, band) = (color(), color());
        Self { ground, band, width: stream.uniform(0.4, 0.9) }
    }

    fn seen_from(&self, viewpoint: &Viewpoint) -> Crop {
        let mut crop = Crop::black();
        let half = CROP_SIDE as f64 / 2.0;
        let light = 1.0 - 0.5 * viewpoint.direction.z;
        for row in 0..CROP_SIDE {
            for column in 0..CROP_SIDE {
                let across = (column as f64 + 0.5 - half) / half;
                let inside = (row as f64 + 0.5 - half).abs() / half < 0.9 - 0.4 * viewpoint.direction.z;
                if !inside || across.abs() > 0.95 {
                    continue;
                }
                let at = viewpoint.azimuth() + across.asin();
                let color = if at.cos() > self.width.cos() { self.band } else { self.ground };
                let start = (row * CROP_SIDE + column) * 3;
                for (shown, own) in crop.0[start..].iter_mut().zip(&color) {
                    *shown = (255.0 * light * own) as u8;
                }
            }
        }
        crop
    }
}
