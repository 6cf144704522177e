//! Straight lines and arcs, one after another.

use super::waypoint::Waypoint;
use nalgebra::Vector2;
use std::f64::consts::PI;

/// Turns smaller than this need no arc, radians.
const STRAIGHT: f64 = 1e-6;

/// Pieces of constant curvature without corners between: a polyline whose corners are rounded, for one.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    pieces: Vec<Piece>,
    /// Arc length at the end of each piece, metres.
    ends: Vec<f64>,
    closed: bool,
}

/// A piece of constant curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: Waypoint,
    /// 1 / metres, positive to the left.
    curvature: f64,
    length: f64,
}

impl Chain {
    /// Joins the points; a corner's arc has this radius, or less where half of a neighbouring line is too short for it.
    ///
    /// Expects two points at least, three if closed, and no two neighbours in the same place.
    pub fn rounded(points: &[Vector2<f64>], closed: bool, radius: f64) -> Self {
        let n = points.len();
        let lines = if closed { n } else { n - 1 };
        let tangent = |line: usize| (points[(line + 1) % n] - points[line % n]).normalize();
        let length = |line: usize| (points[(line + 1) % n] - points[line % n]).norm();
        // What a corner, at the beginning of a line, takes away of it and of the one before: and its signed turn.
        let corner = |line: usize| {
            let line = line % lines;
            if line == 0 && !closed {
                return (0.0, 0.0);
            }
            let (before, after) = ((line + lines - 1) % lines, line);
            let (a, b) = (tangent(before), tangent(after));
            let turn = libm::atan2(a.perp(&b), a.dot(&b));
            if turn.abs() < STRAIGHT {
                return (0.0, 0.0);
            }
            let half = libm::tan(turn.abs() / 2.0);
            (cut(radius * half, length(before), length(after)), turn)
        };
        let mut pieces = Vec::with_capacity(2 * lines);
        for line in 0..lines {
            let (begin, _) = corner(line);
            let (end, turn) = if line + 1 == lines && !closed { (0.0, 0.0) } else { corner(line + 1) };
            let along = tangent(line);
            let from = Waypoint { position: points[line] + along * begin, tangent: along };
            pieces.push(Piece { from, curvature: 0.0, length: length(line) - begin - end });
            if end > 0.0 {
                let radius = end / libm::tan(turn.abs() / 2.0);
                let at = points[(line + 1) % n] - along * end;
                pieces.push(Piece {
                    from: Waypoint { position: at, tangent: along },
                    curvature: turn.signum() / radius,
                    length: turn.abs() * radius,
                });
            }
        }
        Self::of_pieces(pieces, closed)
    }

    /// An open chain of pieces, each by its curvature (1 / metres, positive to the left) and length (metres).
    pub fn of_arcs(mut from: Waypoint, arcs: &[[f64; 2]]) -> Self {
        let piece = |&[curvature, length]: &[f64; 2]| {
            let piece = Piece { from, curvature, length };
            from = piece.at(length);
            piece
        };
        let pieces = arcs.iter().map(piece).collect();
        Self::of_pieces(pieces, false)
    }

    /// Leads back to where it begins, the other way round: to the right, round a circle of this radius to the left, to the right.
    pub fn turning_round(from: Waypoint, radius: f64) -> Self {
        let arc = |side: f64, angle: f64| [side / radius, radius * angle];
        Self::of_arcs(from, &[arc(-1.0, PI / 3.0), arc(1.0, 5.0 * PI / 3.0), arc(-1.0, PI / 3.0)])
    }

    fn of_pieces(pieces: Vec<Piece>, closed: bool) -> Self {
        let ends = pieces
            .iter()
            .scan(0.0, |sum, piece| {
                *sum += piece.length;
                Some(*sum)
            })
            .collect();
        Self { pieces, ends, closed }
    }

    /// Radius of its sharpest arc, metres; infinite without arcs.
    pub fn least_radius(&self) -> f64 {
        self.pieces.iter().fold(f64::INFINITY, |least, piece| least.min(1.0 / piece.curvature.abs()))
    }

    /// Length, metres.
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// The point `distance` metres from the beginning.
    pub fn waypoint(&self, distance: f64) -> Waypoint {
        let along = if self.closed { distance.rem_euclid(self.length()) } else { distance };
        let index = self.ends.partition_point(|end| *end <= along).min(self.pieces.len() - 1);
        let begin = if index == 0 { 0.0 } else { self.ends[index - 1] };
        self.pieces[index].at(along - begin)
    }
}

impl Piece {
    /// The point so far along; beyond its ends it goes straight on.
    fn at(&self, along: f64) -> Waypoint {
        let inside = along.clamp(0.0, self.length);
        let Waypoint { position, tangent } = self.from;
        let left = Vector2::new(-tangent.y, tangent.x);
        let angle = self.curvature * inside;
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        let here = Waypoint {
            position: if self.curvature.abs() > 0.0 {
                position + (tangent * s + left * (1.0 - c)) / self.curvature
            } else {
                position + tangent * inside
            },
            tangent: tangent * c + left * s,
        };
        Waypoint { position: here.position + here.tangent * (along - inside), ..here }
    }
}

/// What an arc takes of its two lines: as wanted, or as much as leaves the other corners theirs.
fn cut(wanted: f64, before: f64, after: f64) -> f64 {
    wanted.min(before / 2.0).min(after / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn points(list: &[[f64; 2]]) -> Vec<Vector2<f64>> {
        list.iter().map(|&p| p.into()).collect()
    }

    fn chains() -> [Chain; 3] {
        let zigzag = points(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [8.0, 3.0], [8.0, 3.4]]);
        let triangle = points(&[[0.0, 0.0], [5.0, 0.0], [0.0, 4.0]]);
        [
            Chain::rounded(&zigzag, false, 0.8),
            Chain::rounded(&triangle, true, 0.5),
            Chain::rounded(&points(&[[0.0, 0.0], [2.0, 0.0], [5.0, 0.0]]), false, 1.0),
        ]
    }

    #[test]
    fn a_chain_is_walked_at_unit_speed_without_jumps() {
        for chain in chains() {
            let h = 1e-5;
            for i in 1..1000 {
                let s = chain.length() * f64::from(i) / 1000.0;
                let (a, b) = (chain.waypoint(s - h), chain.waypoint(s + h));
                assert_relative_eq!(
                    (b.position - a.position) / (2.0 * h),
                    chain.waypoint(s).tangent,
                    epsilon = 1e-3
                );
            }
        }
    }

    #[test]
    fn turning_round_ends_where_it_began_and_keeps_near() {
        let from = Waypoint { position: Vector2::new(2.0, 1.0), tangent: Vector2::new(0.6, 0.8) };
        let turn = Chain::turning_round(from, 0.5);
        let end = turn.waypoint(turn.length());
        assert_relative_eq!(end.position, from.position, epsilon = 1e-9);
        assert_relative_eq!(end.tangent, -from.tangent, epsilon = 1e-9);
        assert_relative_eq!(turn.least_radius(), 0.5);
        for i in 0..=100 {
            let off = turn.waypoint(turn.length() * f64::from(i) / 100.0).position - from.position;
            let (ahead, aside) = (off.dot(&from.tangent), from.tangent.perp(&off));
            assert!(aside.abs() < 0.501 && (-0.001..1.367).contains(&ahead), "{ahead} {aside}");
        }
    }

    #[test]
    fn ends_and_corners_are_where_they_belong() {
        let [zigzag, triangle, line] = chains();
        assert_relative_eq!(zigzag.waypoint(0.0).position, Vector2::zeros());
        assert_relative_eq!(
            zigzag.waypoint(zigzag.length()).position,
            Vector2::new(8.0, 3.4),
            epsilon = 1e-9
        );
        assert_relative_eq!(zigzag.waypoint(zigzag.length() + 1.0).position.y, 4.4, epsilon = 1e-9);
        // Two quarter arcs of radius 0.8, and one that half of the last line, 0.2, bounds.
        let quarter = std::f64::consts::FRAC_PI_2 - 2.0;
        assert_relative_eq!(zigzag.length(), 11.4 + quarter * (0.8 + 0.8 + 0.2), epsilon = 1e-9);
        let lap = triangle.length();
        assert_relative_eq!(
            triangle.waypoint(lap + 0.3).position,
            triangle.waypoint(0.3).position,
            epsilon = 1e-9
        );
        assert_relative_eq!(line.length(), 5.0);
    }
}
