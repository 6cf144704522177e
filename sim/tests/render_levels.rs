//! Levels of detail: what they keep, which is drawn, and that it hardly shows.

mod render_scenes;

use render_scenes::{ball, checks, cluttered, look_at, placed, scene_of};
use std::sync::Arc;
use vantage_dataset::{Seed, Split};
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::object::Object;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Placement, Renderer};
use vantage_sim::scene::Family;
use vantage_sim::texture::Texture;

#[test]
fn levels_keep_attributes_and_lose_triangles() {
    let mut levels = 0;
    for segments in [36, 48] {
        let model = ball(0.1, segments, checks(16, [20, 110, 60], [250, 160, 200]));
        let again = Model::new(model.mesh.clone(), model.texture.clone());
        for level in 1..=model.simpler_levels() {
            let (finer, mesh) = (model.mesh_at(level - 1), model.mesh_at(level));
            assert!(mesh.triangles.len() < finer.triangles.len() && !mesh.triangles.is_empty());
            assert!(mesh == again.mesh_at(level), "a level came out differently");
            let vertices = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
            for ((position, normal), uv) in vertices {
                let original = (0..model.mesh.positions.len()).any(|i| {
                    model.mesh.positions[i] == *position
                        && model.mesh.normals[i] == *normal
                        && model.mesh.uvs[i] == *uv
                });
                assert!(original, "a new vertex in a ball of {segments} segments");
            }
            assert!(mesh.triangles.as_flattened().iter().all(|&i| (i as usize) < mesh.positions.len()));
            levels += 1;
        }
        assert_eq!(model.mesh_at(0), &model.mesh);
        assert_eq!(model.level(-1.0), 0);
        assert_eq!(model.level(f64::INFINITY), model.simpler_levels());
    }
    assert!(levels >= 8, "only {levels} levels");
}

#[test]
fn families_are_drawn_in_full() {
    for family in Family::ALL {
        let object = Object::generate(family, Split::Test, Seed(3), 0);
        assert_eq!(object.model.simpler_levels(), 0, "{}", object.family);
    }
}

#[test]
fn odd_meshes_stay_as_they_are() {
    let texture = || checks(8, [0; 3], [255; 3]);
    let placements = cluttered().placements;
    let blocks = placements.iter().filter(|placement| placement.model.mesh.triangles.len() == 12);
    assert!(blocks.clone().count() == 4 && blocks.clone().all(|block| block.model.simpler_levels() == 0));
    assert_eq!(Model::new(Mesh::default(), texture()).level(1.0), 0);
    let mut infinite = ball(1.0, 40, texture()).mesh.clone();
    infinite.positions[7] = [f32::NAN, 0.0, f32::INFINITY];
    let infinite = Model::new(infinite, texture());
    assert_eq!((infinite.simpler_levels(), infinite.level(1.0)), (0, 0));
}

/// A ball in parts too small for levels of detail.
fn pieces(model: &Model) -> Vec<Arc<Model>> {
    let piece = |triangles: &[[u32; 3]]| {
        let mesh = Mesh { triangles: triangles.to_vec(), ..model.mesh.clone() };
        Arc::new(Model::new(mesh, model.texture.clone()))
    };
    model.mesh.triangles.chunks(1000).map(piece).collect()
}

#[test]
fn far_objects_have_fewer_triangles_and_look_the_same() {
    let ball = ball(0.1, 40, checks(16, [20, 110, 60], [250, 160, 200]));
    let [coarse, fine] = [10.0, 0.05].map(|deviation: f64| ball.level(deviation * 1e-3));
    assert!(coarse > fine && ball.mesh_at(coarse).triangles.len() < ball.mesh.triangles.len() / 2);

    let mut renderer = ReferenceRenderer::new();
    let shot = look_at([1.5, 0.2, 0.5], [0.0; 3]);
    let whole = renderer.frame(&scene_of(vec![placed(&ball, [0.0; 3], 0.0, 1)]), &shot).unwrap();
    let parts: Vec<Placement> = pieces(&ball).iter().map(|piece| placed(piece, [0.0; 3], 0.0, 1)).collect();
    assert!(parts.iter().all(|part| part.model.simpler_levels() == 0));
    let parts = renderer.frame(&scene_of(parts), &shot).unwrap();
    assert!(whole.rgb != parts.rgb, "the ball was drawn in full");

    let seen: Vec<usize> = (0..parts.ids.len()).filter(|&i| parts.ids[i] == 1).collect();
    let lost = (0..parts.ids.len()).filter(|&i| parts.ids[i] != whole.ids[i]).count();
    let levels: u64 = seen
        .iter()
        .flat_map(|&i| 3 * i..3 * i + 3)
        .map(|i| u64::from(parts.rgb[i].abs_diff(whole.rgb[i])))
        .sum();
    let mean = levels as f64 / (3 * seen.len()) as f64;
    assert!(seen.len() > 500 && lost * 20 < seen.len(), "{lost} of {} pixels changed hands", seen.len());
    assert!(mean < 4.0, "{mean} levels");
}

#[test]
fn near_objects_are_drawn_in_full() {
    let ball = ball(0.1, 40, Texture::plain([200, 100, 50]));
    let shot = look_at([0.13, 0.0, 0.0], [0.0; 3]);
    let mut renderer = ReferenceRenderer::new();
    let whole = renderer.frame(&scene_of(vec![placed(&ball, [0.0; 3], 0.0, 1)]), &shot).unwrap();
    let parts = pieces(&ball).iter().map(|piece| placed(piece, [0.0; 3], 0.0, 1)).collect();
    assert_eq!(whole, renderer.frame(&scene_of(parts), &shot).unwrap());
}
