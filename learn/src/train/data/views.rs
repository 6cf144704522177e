//! Views as a training reads them: in groups that may be predicted from each other, with their conditioning.

use crate::architecture::UPRIGHT;
use crate::change::camera_motion;
use crate::role::Convention;
use crate::spec::{Frames, Loss, Motion, TrainingSpec};
use crate::train::error::TrainError;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vantage_dataset::sighting::estimated_viewpoints;
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Seed, Sighting, Split, Stream, View, ViewSet, Viewpoint};

/// Views that know where they are relative to each other.
pub(crate) struct Group {
    /// Their instance, among those that are trained on.
    pub(crate) instance: usize,
    /// Indices into the view set; in the order a robot met them where the training reads odometry.
    pub(crate) views: Vec<usize>,
}

/// A view set, checked and indexed.
pub(crate) struct Views<'a> {
    pub(crate) set: &'a ViewSet,
    /// Viewpoint of each view as far as the training may know it; `None` for views that it cannot use.
    viewpoints: Vec<Option<Viewpoint>>,
    /// By instance; each has two views or more.
    pub(crate) groups: Vec<Group>,
    /// Instances that are trained on.
    pub(crate) instances: usize,
    /// Views in any group.
    pub(crate) usable: Vec<usize>,
    /// Class of each instance that is tagged with one.
    pub(crate) tags: Vec<Option<usize>>,
    /// Number of classes.
    pub(crate) classes: usize,
}

impl<'a> Views<'a> {
    /// Views of a split, finite and with at least `instances` instances to learn from.
    ///
    /// Of true viewpoints, all views of an instance are in one group; by odometry, those of a session, and sightings alone are read.
    pub(crate) fn new(
        set: &'a ViewSet,
        split: Split,
        instances: usize,
        spec: &TrainingSpec,
        seed: Seed,
        odometry: bool,
    ) -> Result<Self, TrainError> {
        if set.split != split {
            return Err(TrainError::Split { got: set.split, expected: split });
        }
        for (index, view) in set.views.iter().enumerate() {
            if !view.viewpoint.conditioning().iter().all(|number| number.is_finite()) {
                return Err(TrainError::Viewpoint { split, view: index });
            }
            if view.instance >= set.instances.len() {
                let (got, instances) = (view.instance, set.instances.len());
                return Err(TrainError::Instance { split, view: index, got, instances });
            }
        }
        if set.views.len() > 1 && set.views.windows(2).all(|pair| pair[0].crop == pair[1].crop) {
            return Err(TrainError::SameCrops { split });
        }
        let (mut viewpoints, found) = match odometry {
            true => dead_reckoned(set, split)?,
            false => known(set, spec.frames, split, seed),
        };
        if spec.predictive.motion == Motion::TrueObjectCentred {
            viewpoints = set.views.iter().map(|view| Some(view.viewpoint)).collect();
        }
        let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
        let mut groups = Vec::new();
        for (instance, views) in found.into_iter().filter(|(_, views)| views.len() >= 2) {
            let next = seen.len();
            groups.push(Group { instance: *seen.entry(instance).or_insert(next), views });
        }
        if seen.len() < instances {
            return Err(TrainError::TooFewInstances { split, got: seen.len(), expected: instances });
        }
        let mut usable: Vec<usize> = groups.iter().flat_map(|group| group.views.iter().copied()).collect();
        usable.sort_unstable();
        let (tags, classes) = tagged(set, &seen, spec, seed);
        if spec.traits().loss == Loss::Class && classes > spec.latent_dim {
            return Err(TrainError::Classes { got: classes, latent: spec.latent_dim });
        }
        Ok(Self { set, viewpoints, groups, instances: seen.len(), usable, tags, classes })
    }

    /// Number of views.
    pub(crate) fn len(&self) -> usize {
        self.set.views.len()
    }

    /// The crops of some views.
    pub(crate) fn crops(&self, views: impl Iterator<Item = usize>) -> Vec<&Crop> {
        views.map(|view| &self.set.views[view].crop).collect()
    }

    /// Some views of one group, over again where it has fewer.
    pub(crate) fn some(&self, count: usize, stream: &mut Stream) -> Vec<usize> {
        let mut views = self.groups[stream.below(self.groups.len())].views.clone();
        stream.shuffle(&mut views);
        views.into_iter().cycle().take(count).collect()
    }

    /// Two views of one group: `count` first ones, then their partners.
    pub(crate) fn pairs(&self, count: usize, stream: &mut Stream) -> Vec<usize> {
        let mut rows = vec![0; 2 * count];
        for row in 0..count {
            let group = &self.groups[stream.below(self.groups.len())].views;
            [rows[row], rows[count + row]] = two_of(group, stream);
        }
        rows
    }

    /// Two views each of up to `count` different groups: first ones, then their partners.
    pub(crate) fn pairs_of_different_groups(&self, count: usize, stream: &mut Stream) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.groups.len()).collect();
        stream.shuffle(&mut order);
        order.truncate(count);
        let (mut rows, mut partners) = (Vec::new(), Vec::new());
        for group in order {
            let [first, second] = two_of(&self.groups[group].views, stream);
            rows.push(first);
            partners.push(second);
        }
        rows.append(&mut partners);
        rows
    }

    /// Azimuth of a usable view, in the frame that its group shares.
    pub(crate) fn azimuth(&self, view: usize) -> f64 {
        self.viewpoints[view].map_or(0.0, |viewpoint| viewpoint.azimuth())
    }

    /// Sine of the elevation, cosine and sine of the roll, log distance.
    pub(crate) fn upright(&self, view: usize) -> [f32; UPRIGHT] {
        let x = self.viewpoints[view].map_or([0.0; CONDITIONING], |viewpoint| viewpoint.conditioning());
        std::array::from_fn(|i| x[2 * HARMONICS + i] as f32)
    }

    /// `first_camera_from_second_camera` of two sightings of a session.
    pub(crate) fn motion(&self, from: usize, to: usize) -> [f32; 9] {
        let pose = |view: usize| self.set.views[view].sighting.as_ref().map(|s| s.session_from_camera);
        let (Some(from), Some(to)) = (pose(from), pose(to)) else { return [0.0; 9] };
        camera_motion(&from.inv_mul(&to)).map(|number| number as f32)
    }

    /// What a decoder is told when view `to` is predicted in the frame of view `from`: see [`Convention`]. `sourced` says
    /// whether it also sees the measurement of `from`.
    pub(crate) fn conditioning(
        &self,
        convention: Option<Convention>,
        from: usize,
        to: usize,
        sourced: bool,
    ) -> Vec<f32> {
        let of = |view: usize| {
            self.viewpoints[view].map_or([0.0; CONDITIONING], |viewpoint| viewpoint.conditioning())
        };
        match convention {
            Some(Convention::AzimuthHarmonics) => of(to).map(|number| number as f32).to_vec(),
            Some(Convention::ObjectCentredChange) => {
                let turned = self.viewpoints[to].map(|viewpoint| viewpoint.turned(-self.azimuth(from)));
                let x = turned.map_or([0.0; CONDITIONING], |viewpoint| viewpoint.conditioning());
                let first = if sourced { self.upright(from) } else { [0.0; UPRIGHT] };
                let change = x[..2 * HARMONICS].iter().map(|&number| number as f32);
                change.chain(first).chain(self.upright(to)).collect()
            }
            Some(Convention::CameraMotion) => self.motion(from, to).to_vec(),
            None => Vec::new(),
        }
    }
}

fn two_of(views: &[usize], stream: &mut Stream) -> [usize; 2] {
    let first = stream.below(views.len());
    let second = (first + 1 + stream.below(views.len() - 1)) % views.len();
    [views[first], views[second]]
}

type Grouped = (Vec<Option<Viewpoint>>, Vec<(usize, Vec<usize>)>);

/// True viewpoints, in the frames that are asked for; all views of an instance in one group.
fn known(set: &ViewSet, frames: Frames, split: Split, seed: Seed) -> Grouped {
    let mut groups = vec![Vec::new(); set.instances.len()];
    for (index, view) in set.views.iter().enumerate() {
        groups[view.instance].push(index);
    }
    let seed = seed.child(split.name(), 0);
    let turn = |instance: usize| seed.stream("frame", instance as u64).uniform(-PI, PI);
    let turns: Vec<f64> = (0..set.instances.len()).map(turn).collect();
    let turned = |view: &View| match frames {
        Frames::Canonical => view.viewpoint,
        Frames::Random | Frames::None => view.viewpoint.turned(turns[view.instance]),
    };
    let viewpoints = set.views.iter().map(|view| Some(turned(view))).collect();
    (viewpoints, groups.into_iter().enumerate().collect())
}

/// Viewpoints by odometry and boxes, the views of a session in one group, in the order of the way.
fn dead_reckoned(set: &ViewSet, split: Split) -> Result<Grouped, TrainError> {
    let mut sessions: BTreeMap<(usize, usize), Vec<(usize, &Sighting)>> = BTreeMap::new();
    for (index, View { instance, session, sighting, .. }) in set.views.iter().enumerate() {
        let sighting = sighting.as_ref().ok_or(TrainError::Sighting { split, view: index })?;
        sessions.entry((*instance, *session)).or_default().push((index, sighting));
    }
    let mut viewpoints = vec![None; set.views.len()];
    let mut groups = Vec::new();
    for ((instance, _), mut session) in sessions {
        session.sort_by_key(|(_, sighting)| sighting.step);
        let (views, sightings): (Vec<usize>, Vec<&Sighting>) = session.into_iter().unzip();
        let estimated = estimated_viewpoints(&sightings);
        for (&view, viewpoint) in views.iter().zip(&estimated) {
            viewpoints[view] = *viewpoint;
        }
        groups.push((instance, views.into_iter().filter(|&view| viewpoints[view].is_some()).collect()));
    }
    Ok((viewpoints, groups))
}

/// Classes of a random share of the instances, numbered in the order of their names.
fn tagged(
    set: &ViewSet,
    kept: &BTreeMap<usize, usize>,
    spec: &TrainingSpec,
    seed: Seed,
) -> (Vec<Option<usize>>, usize) {
    let share = match (spec.traits().loss, &spec.class) {
        (Loss::Class, _) => 1.0,
        (_, Some(class)) => class.tagged,
        (_, None) => return (vec![None; kept.len()], 0),
    };
    let mut names: Vec<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut tags = vec![None; kept.len()];
    for (&instance, &index) in kept {
        if seed.stream("tag", index as u64).chance(share) {
            tags[index] = names.binary_search(&set.instances[instance].family.as_str()).ok();
        }
    }
    (tags, names.len())
}

/// BLAKE3 of all that a training reads of a view set.
pub fn view_set_hash(set: &ViewSet) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(set.split.name().as_bytes());
    hasher.update(&(set.instances.len() as u64).to_le_bytes());
    for instance in &set.instances {
        hasher.update(&instance.id.0.to_le_bytes());
    }
    for view in &set.views {
        hasher.update(&(view.instance as u64).to_le_bytes());
        for number in view.viewpoint.conditioning() {
            hasher.update(&number.to_le_bytes());
        }
        if let Some(sighting) = &view.sighting {
            let Sighting { step, session_from_camera, ray, angular_size } = sighting;
            hasher.update(&(view.session as u64).to_le_bytes());
            hasher.update(&(*step as u64).to_le_bytes());
            let pose = session_from_camera.to_homogeneous();
            for number in pose.iter().chain(ray).chain([angular_size]) {
                hasher.update(&number.to_le_bytes());
            }
        }
        hasher.update(&*view.crop.0);
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::synthetic;

    #[test]
    fn random_frames_turn_all_views_of_an_instance_alike_and_instances_apart() {
        let set = synthetic::views(Split::Train, 3, 4, 1);
        let azimuths = |frames: Frames| -> Vec<f64> {
            let spec = TrainingSpec { frames, ..TrainingSpec::default() };
            let views = Views::new(&set, Split::Train, 2, &spec, Seed(0), false).unwrap();
            (0..set.views.len()).map(|view| views.azimuth(view)).collect()
        };
        let (canonical, random) = (azimuths(Frames::Canonical), azimuths(Frames::Random));
        let truth: Vec<f64> = set.views.iter().map(|view| view.viewpoint.azimuth()).collect();
        assert_eq!(canonical, truth);
        let turn = |view: usize| (random[view] - canonical[view]).rem_euclid(2.0 * PI);
        let turns = [0, 4, 8].map(turn);
        for view in 0..12 {
            assert!((turn(view) - turns[view / 4]).abs() < 1e-9, "view {view}");
        }
        assert!((turns[0] - turns[1]).abs() > 1e-3 && (turns[1] - turns[2]).abs() > 1e-3, "{turns:?}");
    }

    #[test]
    fn pairs_of_different_groups_are_of_one_group_each_and_of_none_twice() {
        let set = synthetic::views(Split::Train, 6, 3, 1);
        let views = Views::new(&set, Split::Train, 2, &TrainingSpec::default(), Seed(0), false).unwrap();
        for (asked, got) in [(4, 4), (6, 6), (9, 6), (1, 1)] {
            let rows = views.pairs_of_different_groups(asked, &mut Seed(3).stream("pairs", asked as u64));
            assert_eq!(rows.len(), 2 * got);
            let mut instances = Vec::new();
            for (&first, &partner) in rows[..got].iter().zip(&rows[got..]) {
                assert!(first != partner);
                assert_eq!(set.views[first].instance, set.views[partner].instance);
                instances.push(set.views[first].instance);
            }
            instances.sort_unstable();
            instances.dedup();
            assert_eq!(instances.len(), got);
        }
    }
}
