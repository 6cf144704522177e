//! Objects are sound as geometry: closed, wound outwards, textured inside the texture, of realistic size.

use vantage_dataset::{Seed, Split};
use vantage_sim::mesh::Mesh;
use vantage_sim::object::Object;
use vantage_sim::scene::Family;

const INSTANCES: u64 = 12;
/// Vertices closer than this are one point, metres; the smallest parts measure about a millimetre.
const WELD: f64 = 1e-6;

type Vector = nalgebra::Vector3<f64>;

fn every_object(mut check: impl FnMut(&Object, &str)) {
    for family in Family::ALL {
        for index in 0..INSTANCES {
            let object = Object::generate(family, Split::Train, Seed(3), index);
            check(&object, &format!("{} {index}", family.name()));
        }
    }
}

fn point(mesh: &Mesh, vertex: u32) -> Vector {
    Vector::from(mesh.positions[vertex as usize].map(f64::from))
}

/// For each vertex the first vertex at the same place.
fn welded(mesh: &Mesh) -> Vec<u32> {
    let count = mesh.positions.len() as u32;
    let points: Vec<Vector> = (0..count).map(|v| point(mesh, v)).collect();
    let first = |v: u32| (0..v).find(|&u| (points[u as usize] - points[v as usize]).norm() < WELD);
    (0..count).map(|v| first(v).unwrap_or(v)).collect()
}

#[test]
fn vertices_are_finite_and_normals_unit_and_uvs_and_corners_in_range() {
    every_object(|object, name| {
        let mesh = &object.model.mesh;
        let count = mesh.positions.len();
        assert!(mesh.normals.len() == count && mesh.uvs.len() == count, "{name}");
        for vertex in 0..count {
            assert!(mesh.positions[vertex].iter().all(|x| x.is_finite()), "{name}: vertex {vertex}");
            let length = Vector::from(mesh.normals[vertex].map(f64::from)).norm();
            assert!((length - 1.0).abs() < 1e-6, "{name}: normal {vertex} has length {length}");
            assert!(mesh.uvs[vertex].iter().all(|x| (0.0..=1.0).contains(x)), "{name}: uv {vertex}");
        }
        let corners = mesh.triangles.iter().flatten();
        assert!(corners.into_iter().all(|&corner| (corner as usize) < count), "{name}");
        let triangles = mesh.triangles.len();
        assert!((60..=900).contains(&triangles), "{name}: {triangles} triangles");
    });
}

#[test]
fn triangles_face_the_way_of_their_normals() {
    every_object(|object, name| {
        let mesh = &object.model.mesh;
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| point(mesh, corner));
            let area = (b - a).cross(&(c - a));
            let shading: Vector =
                corners.iter().map(|&v| Vector::from(mesh.normals[v as usize].map(f64::from))).sum();
            assert!(area.norm() > 1e-12, "{name}: {corners:?} has no area");
            assert!(area.dot(&shading) > 0.0, "{name}: {corners:?} faces against its normals");
        }
    });
}

#[test]
fn every_part_is_closed_and_encloses_a_positive_volume() {
    every_object(|object, name| {
        let mesh = &object.model.mesh;
        let weld = welded(mesh);
        let triangles: Vec<[u32; 3]> =
            mesh.triangles.iter().map(|corners| corners.map(|v| weld[v as usize])).collect();

        let mut edges: Vec<(u32, u32)> =
            triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        let mut reversed: Vec<(u32, u32)> = edges.iter().map(|&(a, b)| (b, a)).collect();
        edges.sort_unstable();
        reversed.sort_unstable();
        let open = edges.iter().zip(&reversed).find(|(edge, back)| edge != back);
        assert!(open.is_none(), "{name}: edge {open:?} bounds a hole");

        let mut part: Vec<u32> = (0..weld.len() as u32).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for corners in &triangles {
                let least = corners.map(|v| part[v as usize]).into_iter().min().unwrap();
                for &v in corners {
                    changed |= part[v as usize] != least;
                    part[v as usize] = least;
                }
            }
        }
        let mut volumes = std::collections::BTreeMap::<u32, f64>::new();
        for corners in &triangles {
            let [a, b, c] = corners.map(|v| point(mesh, v));
            *volumes.entry(part[corners[0] as usize]).or_default() += a.dot(&b.cross(&c)) / 6.0;
        }
        for (first, volume) in volumes {
            assert!(volume > 1e-9, "{name}: the part of vertex {first} encloses {volume} m^3");
        }
    });
}

#[test]
fn sizes_and_masses_are_those_of_things_on_a_table() {
    every_object(|object, name| {
        let mesh = &object.model.mesh;
        for axis in 0..3 {
            let values = || mesh.positions.iter().map(|p| f64::from(p[axis]));
            let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
            assert!((low + high).abs() < 1e-6, "{name}: the bounding box is off centre");
            assert!((high - object.half_extents[axis]).abs() < 1e-6, "{name}: half extents");
        }
        let radius = (0..mesh.positions.len() as u32).map(|v| point(mesh, v).norm()).fold(0.0, f64::max);
        assert!((2.0 * radius - object.size).abs() < 1e-6, "{name}");
        assert!((0.06..=0.3).contains(&object.size), "{name}: {} m", object.size);
        assert!((0.02..=2.5).contains(&object.mass), "{name}: {} kg", object.mass);
    });
}

#[test]
fn the_hull_has_few_points_and_nearly_spans_the_mesh() {
    every_object(|object, name| {
        let mesh = &object.model.mesh;
        assert!((8..=64).contains(&object.hull.len()), "{name}: {} points", object.hull.len());
        let reach = |points: &[[f32; 3]], d: &Vector| {
            points.iter().map(|p| Vector::from(p.map(f64::from)).dot(d)).fold(f64::MIN, f64::max)
        };
        assert!(object.hull.iter().all(|p| mesh.positions.contains(p)), "{name}: a point off the mesh");
        for axis in [Vector::x(), Vector::y(), Vector::z()] {
            for d in [axis, -axis] {
                assert_eq!(reach(&object.hull, &d), reach(&mesh.positions, &d), "{name}: extent along {d}");
            }
        }
        let mut stream = Seed(4).stream("hull", 0);
        for _ in 0..200 {
            let d = Vector::new(stream.normal(), stream.normal(), stream.normal()).normalize();
            let lost = reach(&mesh.positions, &d) - reach(&object.hull, &d);
            assert!(lost < 0.03 * object.size, "{name}: {lost} m lost along {d}");
        }
    });
}
