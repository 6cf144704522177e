//! Where objects are put down.

use crate::error::SimError;
use crate::object::Object;
use crate::plan::stand::{Outline, Stand};
use nalgebra::Vector2;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Positions tried for one object before the whole layout is begun anew.
const TRIES: usize = 2_000;
/// Layouts begun before giving up.
const RESTARTS: usize = 20;
/// Objects in a row without room after which the others are taken to have none.
const MISSES: usize = 50;

/// Where one object is put down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Index of its stand.
    pub stand: usize,
    /// World frame, metres.
    pub position: Vector2<f64>,
    /// Turn about the vertical, radians.
    pub yaw: f64,
}

/// What an upright object needs of a stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Radius of the circle around it, metres.
    pub radius: f64,
    /// Height, metres.
    pub height: f64,
}

impl Footprint {
    /// An object's.
    pub fn of(object: &Object) -> Self {
        Self { radius: object.footprint(), height: 2.0 * object.half_extents[2] }
    }
}

/// Free height that is left above an object, metres.
const AIR: f64 = 0.03;

/// Draws a place for each object: wholly on a stand, circles at least `spacing` apart. A single stand holds all objects,
/// pedestals one each; to furniture they are dealt out by the area of what is high enough for them.
pub fn draw(
    stands: &[Stand],
    surface: &'static str,
    footprints: &[Footprint],
    spacing: f64,
    stream: &mut Stream,
) -> Result<Vec<Place>, SimError> {
    let layout = Layout { stands, footprints, spacing };
    let mut order: Vec<usize> = (0..footprints.len()).collect();
    order.sort_by(|a, b| footprints[*b].radius.total_cmp(&footprints[*a].radius));
    for _ in 0..RESTARTS {
        if let Some(places) = layout.of_all(&order, stream) {
            return Ok(places);
        }
    }
    // Of the smallest the most fit.
    order.reverse();
    let placed: Vec<_> = (0..RESTARTS).map(|_| layout.of_some(&order, stream)).collect();
    let placed = placed.into_iter().max_by_key(Vec::len).unwrap_or_default();
    let (fitting, wanted) = (placed.len(), footprints.len());
    if fitting < wanted {
        Err(SimError::NothingFits { fitting, wanted, surface })
    } else {
        Ok(in_turn(placed))
    }
}

/// The places of all objects, by their index.
fn in_turn(mut placed: Vec<(usize, Place)>) -> Vec<Place> {
    placed.sort_by_key(|(object, _)| *object);
    placed.into_iter().map(|(_, place)| place).collect()
}

/// What is to be placed, and on what.
struct Layout<'a> {
    stands: &'a [Stand],
    footprints: &'a [Footprint],
    spacing: f64,
}

impl Layout<'_> {
    /// Places objects in this order, up to the first that finds no room: then none.
    fn of_all(&self, order: &[usize], stream: &mut Stream) -> Option<Vec<Place>> {
        let mut placed = Vec::with_capacity(order.len());
        for &object in order {
            placed.push((object, self.place(object, &placed, stream)?));
        }
        Some(in_turn(placed))
    }

    /// Places objects in this order, but for those that find no room, until too many in a row found none.
    fn of_some(&self, order: &[usize], stream: &mut Stream) -> Vec<(usize, Place)> {
        let (mut placed, mut misses) = (Vec::new(), 0);
        for &object in order {
            match self.place(object, &placed, stream) {
                Some(place) => {
                    placed.push((object, place));
                    misses = 0;
                }
                None if misses == MISSES => break,
                None => misses += 1,
            }
        }
        placed
    }

    /// A place beside those that were placed.
    fn place(&self, object: usize, placed: &[(usize, Place)], stream: &mut Stream) -> Option<Place> {
        let &Self { stands, footprints, spacing } = self;
        let Footprint { radius, height } = footprints[object];
        let fitting: Vec<usize> = (0..stands.len()).filter(|&i| height + AIR <= stands[i].headroom).collect();
        let choose = |stream: &mut Stream| match stands {
            [_] => Some(0),
            [first, ..] if first.solid => Some(object),
            _ => by_area(stands, &fitting, stream),
        };
        let free = |(stand, position): &(usize, Vector2<f64>)| {
            let same = |place: &Place| stands[*stand].solid || place.stand == *stand;
            placed.iter().filter(|(_, place)| same(place)).all(|(other, place)| {
                (place.position - position).norm() >= footprints[*other].radius + radius + spacing
            })
        };
        let (stand, position) = (0..TRIES)
            .filter_map(|_| {
                let stand = choose(stream)?;
                Some((stand, stands[stand].draw_position(radius, stream)?))
            })
            .find(free)?;
        Some(Place { stand, position, yaw: stream.uniform(-PI, PI) })
    }
}

/// One of the fitting stands, the larger the likelier.
fn by_area(stands: &[Stand], fitting: &[usize], stream: &mut Stream) -> Option<usize> {
    let total: f64 = fitting.iter().map(|&i| stands[i].outline.area()).sum();
    let mut left = total * stream.unit();
    fitting.iter().copied().find(|&i| {
        left -= stands[i].outline.area();
        left < 0.0
    })
}

impl Stand {
    /// A point at which a circle of this radius lies wholly on the stand; `None` where there is none.
    fn draw_position(&self, radius: f64, stream: &mut Stream) -> Option<Vector2<f64>> {
        let (a, b) = (stream.unit(), stream.unit());
        match self.outline {
            Outline::Disc { radius: outer } => {
                let angle = 2.0 * PI * b;
                let at = Vector2::new(libm::cos(angle), libm::sin(angle)) * libm::sqrt(a);
                (outer >= radius).then(|| self.center + at * (outer - radius))
            }
            Outline::Rectangle { half_extents: [x, y] } => {
                let free = Vector2::new(x - radius, y - radius);
                let at = Vector2::new(2.0 * a - 1.0, 2.0 * b - 1.0);
                (free.min() >= 0.0).then(|| self.center + at.component_mul(&free))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn table(outline: Outline) -> [Stand; 1] {
        [Stand::solid(Vector2::new(1.0, 2.0), 0.7, outline)]
    }

    #[test]
    fn places_keep_on_the_stand_and_apart() {
        let footprints = [0.05, 0.1, 0.02, 0.1, 0.05, 0.08].map(|radius| Footprint { radius, height: 0.1 });
        for outline in [Outline::Disc { radius: 0.4 }, Outline::Rectangle { half_extents: [0.5, 0.3] }] {
            let places =
                draw(&table(outline), "table", &footprints, 0.03, &mut Seed(1).stream("layout", 0)).unwrap();
            for (i, place) in places.iter().enumerate() {
                let at = place.position - Vector2::new(1.0, 2.0);
                let r = footprints[i].radius - 1e-12;
                match outline {
                    Outline::Disc { radius } => assert!(at.norm() + r <= radius),
                    Outline::Rectangle { half_extents: [x, y] } => {
                        assert!(at.x.abs() + r <= x && at.y.abs() + r <= y);
                    }
                }
                for (j, other) in places.iter().enumerate().take(i) {
                    assert!((other.position - place.position).norm() >= footprints[j].radius + r + 0.03);
                }
            }
        }
    }

    #[test]
    fn a_surface_too_small_says_how_many_fit() {
        let got = draw(
            &table(Outline::Disc { radius: 0.21 }),
            "table",
            &[Footprint { radius: 0.1, height: 0.1 }; 4],
            0.01,
            &mut Seed(1).stream("layout", 0),
        );
        assert!(matches!(got, Err(SimError::NothingFits { fitting: 2, wanted: 4, .. })), "{got:?}");
    }

    #[test]
    fn one_object_too_large_is_not_counted_for_all() {
        let footprint = |radius| Footprint { radius, height: 0.1 };
        let mut footprints = vec![footprint(0.03); 11];
        footprints.insert(4, footprint(0.5));
        let table = table(Outline::Disc { radius: 0.4 });
        let got = draw(&table, "table", &footprints, 0.01, &mut Seed(1).stream("layout", 0));
        let said = got.unwrap_err().to_string();
        assert!(said.starts_with("only 11 of 12 objects fit on the table"), "{said}");
    }

    #[test]
    fn furniture_holds_what_is_low_enough_for_it() {
        let board = |height: f64, headroom: f64| Stand {
            center: Vector2::zeros(),
            height,
            outline: Outline::Rectangle { half_extents: [0.5, 0.2] },
            headroom,
            solid: false,
        };
        let stands = [board(0.3, 0.2), board(0.6, f64::INFINITY)];
        let footprints = [(0.05, 0.3), (0.05, 0.1), (0.1, 0.25), (0.06, 0.15), (0.05, 0.1), (0.05, 0.1)]
            .map(|(radius, height)| Footprint { radius, height });
        let mut below = 0;
        for seed in 0..20 {
            let places =
                draw(&stands, "furniture", &footprints, 0.02, &mut Seed(seed).stream("layout", 0)).unwrap();
            for (place, footprint) in places.iter().zip(&footprints) {
                assert!(footprint.height < stands[place.stand].headroom);
                below += usize::from(place.stand == 0);
            }
        }
        assert!((20..60).contains(&below), "{below} of 80 low objects on the lower of two equal boards");
    }
}
