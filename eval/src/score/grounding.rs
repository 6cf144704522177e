//! Grounding (IV-A): what class an embedding is of, told from a few tagged images of each class.

use super::retrieval::{are_comparable, squared_distance};
use std::collections::BTreeMap;
use vantage_dataset::{Seed, Stream};

/// Tagged images of each class.
pub const TAGS: [usize; 4] = [1, 2, 5, 10];
/// Tagged objects of each class, where episodes leave one embedding of an object.
pub const OBJECT_TAGS: [usize; 2] = [1, 3];
/// Draws of tags that accuracies are means over.
const DRAWS: u64 = 20;

/// Share of embeddings given their right class, with each of [`TAGS`]; `None` where a class has too few images.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grounding {
    /// By the class of the nearest tagged image.
    pub nearest: [Option<f64>; 4],
    /// By `P(e | c)` of Eq. 23, a Gaussian about the mean of the class's tags with one constant covariance `s^2 I`.
    /// Classes being equally likely beforehand, that is the nearest mean whatever `s`; with one tag, the nearest image.
    pub gaussian: [Option<f64>; 4],
}

/// Class accuracy from few tags, over 20 draws of them.
///
/// In each draw the instances of a class are parted at random: half of them, rounded up, may be tagged, the others are
/// scored, all of their images. So no instance that anything was said of is scored, the images scored do not depend on the
/// number of tags, and a class with one instance is left out. With `k` tags a class has the `k` first of its draw's images.
///
/// Embeddings as near to a wrong class as to the right one are wrong. Renaming classes or instances changes no bit.
/// `None` where the embeddings are not finite and of one length, or fewer than two classes have two instances.
///
/// # Panics
/// If there is not one instance and one class an embedding.
pub fn ground(
    embeddings: &[Vec<f32>],
    instances: &[usize],
    classes: &[usize],
    seed: Seed,
) -> Option<Grounding> {
    assert_eq!(embeddings.len(), instances.len(), "each embedding needs its instance");
    assert_eq!(embeddings.len(), classes.len(), "each embedding needs its class");
    let members = members(instances, classes);
    if members.len() < 2 || !are_comparable(embeddings) {
        return None;
    }
    let mut sums = Grounding::default();
    for draw in 0..DRAWS {
        let mut stream = seed.stream("tags", draw);
        let parted: Vec<Parted> = members.iter().map(|class| Parted::draw(class, &mut stream)).collect();
        for (i, &k) in TAGS.iter().enumerate() {
            let enough = parted.iter().all(|class| class.taggable.len() >= k);
            let of = |nearest: bool| enough.then(|| accuracy(embeddings, &parted, k, nearest));
            // The images available differ between draws: a mean over some of them would be of easier ones.
            let add = |sum: Option<f64>, value: Option<f64>| match draw {
                0 => value,
                _ => Some(sum? + value?),
            };
            sums.nearest[i] = add(sums.nearest[i], of(true));
            sums.gaussian[i] = add(sums.gaussian[i], of(false));
        }
    }
    let mean = |sums: [Option<f64>; 4]| sums.map(|sum| Some(sum? / DRAWS as f64));
    Some(Grounding { nearest: mean(sums.nearest), gaussian: mean(sums.gaussian) })
}

/// Share of the `asked` given their right class, by the nearest mean of [`OBJECT_TAGS`] of the `known` of each class (as
/// [`Grounding::gaussian`]); the mean over 20 draws. Of each object its class and its embedding.
///
/// Classes with fewer known objects than the most tags are left out: the same are told apart with few tags and with many.
/// `None` where fewer than two classes are left, nothing asked is of them, or the embeddings are not finite and of one length.
pub fn ground_objects(
    known: &[(&str, &[f32])],
    asked: &[(&str, &[f32])],
    seed: Seed,
) -> Option<[f64; OBJECT_TAGS.len()]> {
    let embeddings: Vec<Vec<f32>> = known.iter().chain(asked).map(|(_, of)| of.to_vec()).collect();
    let mut parted: BTreeMap<&str, Parted> = BTreeMap::new();
    for (index, (class, _)) in known.iter().enumerate() {
        parted.entry(class).or_default().taggable.push(index);
    }
    let most = OBJECT_TAGS.into_iter().max()?;
    parted.retain(|_, class| class.taggable.len() >= most);
    for (index, (class, _)) in asked.iter().enumerate() {
        if let Some(class) = parted.get_mut(class) {
            class.scored.push(known.len() + index);
        }
    }
    let mut parted: Vec<Parted> = parted.into_values().collect();
    let is_asked = parted.iter().any(|class| !class.scored.is_empty());
    if parted.len() < 2 || !is_asked || !are_comparable(&embeddings) {
        return None;
    }
    let mut sums = [0.0; OBJECT_TAGS.len()];
    for draw in 0..DRAWS {
        let mut stream = seed.stream("tags", draw);
        parted.iter_mut().for_each(|class| stream.shuffle(&mut class.taggable));
        for (sum, k) in sums.iter_mut().zip(OBJECT_TAGS) {
            *sum += accuracy(&embeddings, &parted, k, false);
        }
    }
    Some(sums.map(|sum| sum / DRAWS as f64))
}

/// Images by instance by class, classes with two instances or more, all by first occurrence.
fn members(instances: &[usize], classes: &[usize]) -> Vec<Vec<Vec<usize>>> {
    let mut places: BTreeMap<usize, (usize, BTreeMap<usize, usize>)> = BTreeMap::new();
    let mut members: Vec<Vec<Vec<usize>>> = Vec::new();
    for (image, (instance, class)) in instances.iter().zip(classes).enumerate() {
        let (place, own) = places.entry(*class).or_insert_with(|| {
            members.push(Vec::new());
            (members.len() - 1, BTreeMap::new())
        });
        let of_class = &mut members[*place];
        let index = *own.entry(*instance).or_insert_with(|| {
            of_class.push(Vec::new());
            of_class.len() - 1
        });
        of_class[index].push(image);
    }
    members.retain(|class| class.len() >= 2);
    members
}

/// A class in one draw.
#[derive(Default)]
struct Parted {
    /// Images to tag, in the order they are.
    taggable: Vec<usize>,
    /// Images to score.
    scored: Vec<usize>,
}

impl Parted {
    fn draw(class: &[Vec<usize>], stream: &mut Stream) -> Self {
        let mut order: Vec<usize> = (0..class.len()).collect();
        stream.shuffle(&mut order);
        let (tagged, scored) = order.split_at(class.len().div_ceil(2));
        let images = |of: &[usize]| of.iter().flat_map(|&instance| class[instance].clone()).collect();
        let mut taggable: Vec<usize> = images(tagged);
        stream.shuffle(&mut taggable);
        Self { taggable, scored: images(scored) }
    }
}

/// With `k` tags a class, by the nearest tagged image or by the nearest mean of the tags.
fn accuracy(embeddings: &[Vec<f32>], classes: &[Parted], k: usize, nearest: bool) -> f64 {
    let known: Vec<Vec<Vec<f32>>> = classes
        .iter()
        .map(|class| {
            let tags: Vec<&Vec<f32>> = class.taggable[..k].iter().map(|&image| &embeddings[image]).collect();
            if nearest { tags.into_iter().cloned().collect() } else { vec![mean(&tags)] }
        })
        .collect();
    let (mut right, mut scored) = (0usize, 0usize);
    for (own, class) in classes.iter().enumerate() {
        for &image in &class.scored {
            let distances: Vec<f64> = known
                .iter()
                .map(|of| {
                    of.iter().map(|e| squared_distance(&embeddings[image], e)).fold(f64::INFINITY, f64::min)
                })
                .collect();
            let rivals = distances.iter().enumerate().filter(|&(other, _)| other != own);
            right += usize::from(rivals.map(|(_, &d)| d).fold(f64::INFINITY, f64::min) > distances[own]);
            scored += 1;
        }
    }
    right as f64 / scored as f64
}

fn mean(vectors: &[&Vec<f32>]) -> Vec<f32> {
    let sum = |j: usize| vectors.iter().map(|v| f64::from(v[j])).sum::<f64>();
    (0..vectors[0].len()).map(|j| (sum(j) / vectors.len() as f64) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `classes` classes of `instances` instances of `images` images: instance and class of each.
    fn labels(classes: usize, instances: usize, images: usize) -> (Vec<usize>, Vec<usize>) {
        (0..classes * instances * images).map(|i| (i / images, i / images / instances)).unzip()
    }

    fn noise(n: usize, scale: f64) -> Vec<Vec<f32>> {
        let mut stream = Seed(9).stream("noise", 0);
        (0..n).map(|_| (0..4).map(|_| (scale * stream.normal()) as f32).collect()).collect()
    }

    #[test]
    fn classes_apart_are_told_from_one_tag_and_noise_is_at_chance() {
        let (instances, classes) = labels(5, 4, 20);
        let mut apart = noise(instances.len(), 1.0);
        apart.iter_mut().zip(&classes).for_each(|(e, &class)| e[0] += 1e3 * class as f32);
        let found = ground(&apart, &instances, &classes, Seed(0)).unwrap();
        assert_eq!(found, Grounding { nearest: [Some(1.0); 4], gaussian: [Some(1.0); 4] });
        let random = ground(&noise(instances.len(), 1.0), &instances, &classes, Seed(0)).unwrap();
        for share in random.nearest.iter().chain(&random.gaussian) {
            assert!((share.unwrap() - 0.2).abs() < 0.06, "{random:?}");
        }
    }

    #[test]
    fn more_tags_help_where_classes_overlap_and_one_tag_is_its_own_mean() {
        let (instances, classes) = labels(4, 6, 10);
        let mut close = noise(instances.len(), 1.0);
        close.iter_mut().zip(&classes).for_each(|(e, &class)| e[class] += 2.0);
        let found = ground(&close, &instances, &classes, Seed(1)).unwrap();
        let [one, _, five, ten] = found.gaussian.map(Option::unwrap);
        assert!(one + 0.1 < five && five < ten + 0.05, "{found:?}");
        assert_eq!(found.nearest[0], found.gaussian[0]);
    }

    #[test]
    fn instances_told_of_are_not_scored() {
        // Each instance in a place of its own, classes all over: images of tagged instances would be right.
        let (instances, classes) = labels(3, 4, 6);
        let places: Vec<usize> = vec![0, 7, 4, 9, 3, 10, 1, 6, 8, 2, 11, 5];
        let own: Vec<Vec<f32>> = instances.iter().map(|&i| vec![1e3 * places[i] as f32]).collect();
        let found = ground(&own, &instances, &classes, Seed(2)).unwrap();
        assert!(found.nearest[3].unwrap() < 0.7, "{found:?}");
    }

    #[test]
    fn names_change_no_bit_and_seeds_only_the_draws() {
        let (instances, classes) = labels(3, 3, 7);
        let embeddings = noise(instances.len(), 1.0);
        let here = ground(&embeddings, &instances, &classes, Seed(3)).unwrap();
        let renamed: Vec<usize> = classes.iter().map(|c| 50 - c).collect();
        let moved: Vec<usize> = instances.iter().map(|i| 90 - i).collect();
        assert_eq!(ground(&embeddings, &moved, &renamed, Seed(3)), Some(here));
        assert_ne!(ground(&embeddings, &instances, &classes, Seed(4)), Some(here));
    }

    #[test]
    fn too_few_images_or_classes_are_undefined() {
        let (instances, classes) = labels(2, 2, 4);
        let found = ground(&noise(16, 1.0), &instances, &classes, Seed(0)).unwrap();
        assert!(found.nearest[1].is_some() && found.nearest[2].is_none() && found.gaussian[3].is_none());
        let (instances, classes) = labels(5, 1, 4);
        assert_eq!(ground(&noise(20, 1.0), &instances, &classes, Seed(0)), None);
        assert_eq!(ground(&[], &[], &[], Seed(0)), None);
        let collapsed = vec![vec![1.0f32]; 48];
        let (instances, classes) = labels(2, 2, 12);
        assert_eq!(ground(&collapsed, &instances, &classes, Seed(0)).unwrap().nearest[3], Some(0.0));
    }

    #[test]
    fn objects_are_asked_of_classes_that_have_all_tags() {
        let known: Vec<(&str, [f32; 1])> = (0..9)
            .map(|i| (["mug", "book", "shoe"][i % 3], [(i % 3) as f32]))
            .chain([("duck", [9.0])])
            .collect();
        let known: Vec<(&str, &[f32])> = known.iter().map(|(class, of)| (*class, &of[..])).collect();
        let of = |asked: &[(&str, &[f32])]| ground_objects(&known, asked, Seed(0));
        assert_eq!(of(&[("mug", &[0.1]), ("book", &[1.2])]), Some([1.0, 1.0]));
        assert_eq!(of(&[("mug", &[0.1]), ("book", &[0.2])]), Some([0.5, 0.5]));
        assert_eq!(of(&[("mug", &[0.1]), ("duck", &[2.0])]), Some([1.0, 1.0]), "one duck is known");
        assert_eq!(of(&[("mug", &[0.5])]), Some([0.0, 0.0]), "as near to a book");
        for asked in [&[][..], &[("duck", &[9.0][..])], &[("mug", &[f32::NAN])], &[("mug", &[0.0, 0.0])]] {
            assert_eq!(of(asked), None);
        }
        assert_eq!(ground_objects(&known[..2], &[("mug", &[0.0])], Seed(0)), None, "no class has three");
    }

    #[test]
    fn three_tagged_objects_tell_more_than_one_and_those_alike_nothing() {
        let mut stream = Seed(4).stream("objects", 0);
        let mut draw = |apart: f64| -> Vec<(&str, Vec<f32>)> {
            let mut of = |class: usize, axis: usize| -> f32 {
                (apart * f64::from(u8::from(class == axis)) + stream.normal()) as f32
            };
            let names = ["a", "b", "c", "d"];
            (0..400).map(|i| (names[i % 4], (0..4).map(|axis| of(i % 4, axis)).collect())).collect()
        };
        let share = |objects: &[(&str, Vec<f32>)]| {
            let of: Vec<(&str, &[f32])> = objects.iter().map(|(class, of)| (*class, &of[..])).collect();
            ground_objects(&of[..200], &of[200..], Seed(1)).unwrap()
        };
        let [one, three] = share(&draw(3.0));
        assert!(one > 0.5 && three > one + 0.1, "{one} {three}");
        assert!(share(&draw(0.0)).iter().all(|share| (share - 0.25).abs() < 0.06));
        let alike: Vec<(&str, Vec<f32>)> = (0..400).map(|i| (["a", "b"][i % 2], vec![0.0])).collect();
        assert_eq!(share(&alike), [0.0, 0.0]);
    }
}
