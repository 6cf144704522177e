//! What the objects of a world, or the instances of a split, are drawn from.

use super::{MeshEntry, MeshLibrary, Object};
use crate::mesh_file::MeshFileError;
use crate::scene::Family;
use std::collections::VecDeque;
use vantage_dataset::{Seed, Split};

/// The families of a scene, which never run out, and its meshes, which are one instance each.
#[derive(Clone, Copy, Debug)]
pub struct Catalog<'a> {
    families: &'a [Family],
    meshes: &'a MeshLibrary,
    split: Split,
}

/// An object that has not been drawn yet.
#[derive(Clone, Copy, Debug)]
pub enum Draw<'a> {
    /// Any instance of a family.
    Family(Family),
    /// A mesh.
    Mesh(&'a MeshEntry),
}

/// Objects of a kind: a family, or the meshes of a category, in turn.
enum Kind<'a> {
    Family(Family),
    Meshes(VecDeque<&'a MeshEntry>),
}

impl<'a> Catalog<'a> {
    /// What there is for a split.
    pub fn new(families: &'a [Family], meshes: &'a MeshLibrary, split: Split) -> Self {
        Self { families, meshes, split }
    }

    /// The first `count` instances, which a seed does not change: each family and each category of meshes in turn,
    /// a category only as long as it has meshes left. Fewer if there are fewer.
    pub fn in_turn(&self, count: usize) -> Vec<Draw<'a>> {
        take_turns(self.kinds(), 0, count)
    }

    /// As [`Catalog::in_turn`], with composites where `is_composite` says so of an index.
    pub fn in_turn_beside_composites(
        &self,
        count: usize,
        is_composite: impl Fn(usize) -> bool,
    ) -> Vec<Draw<'a>> {
        let mut others = self.in_turn((0..count).filter(|&i| !is_composite(i)).count()).into_iter();
        (0..count)
            .map_while(
                |i| if is_composite(i) { Some(Draw::Family(Family::Composite)) } else { others.next() },
            )
            .collect()
    }

    /// `count` objects in random order, each family and each category of meshes as often as any other, to within one,
    /// as long as it has meshes left. Fewer if there are fewer.
    pub fn shuffled(&self, count: usize, seed: Seed) -> Vec<Draw<'a>> {
        let mut kinds = self.kinds();
        if kinds.is_empty() {
            return Vec::new();
        }
        for (i, kind) in kinds.iter_mut().enumerate() {
            if let Kind::Meshes(meshes) = kind {
                seed.stream("meshes", i as u64).shuffle(meshes.make_contiguous());
            }
        }
        let mut stream = seed.stream("families", 0);
        let first = stream.below(kinds.len());
        let mut drawn = take_turns(kinds, first, count);
        stream.shuffle(&mut drawn);
        drawn
    }

    fn kinds(&self) -> Vec<Kind<'a>> {
        let mut kinds: Vec<Kind<'a>> = self.families.iter().map(|family| Kind::Family(*family)).collect();
        let mut categories: Vec<(&str, VecDeque<&MeshEntry>)> = Vec::new();
        for mesh in self.meshes.iter().filter(|mesh| mesh.split == self.split) {
            match categories.iter_mut().find(|(category, _)| *category == mesh.category) {
                Some((_, meshes)) => meshes.push_back(mesh),
                None => categories.push((&mesh.category, VecDeque::from([mesh]))),
            }
        }
        kinds.extend(categories.into_iter().map(|(_, meshes)| Kind::Meshes(meshes)));
        kinds
    }
}

fn take_turns<'a>(mut kinds: Vec<Kind<'a>>, first: usize, count: usize) -> Vec<Draw<'a>> {
    let mut drawn = Vec::new();
    let mut turn = first;
    let mut passed = 0;
    while drawn.len() < count && passed < kinds.len() {
        let number = kinds.len();
        let draw = match &mut kinds[turn % number] {
            Kind::Family(family) => Some(Draw::Family(*family)),
            Kind::Meshes(meshes) => meshes.pop_front().map(Draw::Mesh),
        };
        passed = if draw.is_some() { 0 } else { passed + 1 };
        drawn.extend(draw);
        turn += 1;
    }
    drawn
}

impl Draw<'_> {
    /// The object; of a family, instance `index` of the split and seed.
    ///
    /// # Errors
    /// Those of [`MeshEntry::object`].
    pub fn object(self, split: Split, seed: Seed, index: u64) -> Result<Object, MeshFileError> {
        match self {
            Draw::Family(family) => Ok(Object::generate(family, split, seed, index)),
            Draw::Mesh(mesh) => mesh.object(),
        }
    }
}
