//! Objects that look like others.

use super::view::log_sum;

/// A log-ratio `all` of so many tracklets, less what copies explain: of objects that are not the same a share `c` look alike.
///
/// ```text
/// all - (n - 1) log(1 - c + c r)      r the ratio of looks to each further tracklet, (n - 1) log r = looks
/// ```
///
/// So looks add no more than `-log c` for each tracklet beyond the first.
pub(super) fn less_copies(all: f64, looks: f64, (tracklets, share): (usize, f64)) -> f64 {
    let further = tracklets.saturating_sub(1).max(1) as f64;
    all - further * log_sum(libm::log(1.0 - share), libm::log(share) + looks / further)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn looks_add_no_more_than_the_rarity_of_copies_for_each_further_tracklet() {
        assert_relative_eq!(less_copies(1000.0, 1000.0, (2, 0.1)), libm::log(10.0), epsilon = 1e-9);
        assert_relative_eq!(less_copies(3000.0, 3000.0, (4, 0.1)), 3.0 * libm::log(10.0), epsilon = 1e-9);
        // A side that looks do not tell counts in full, and what tells against one object nearly so.
        assert_relative_eq!(less_copies(1005.0, 1000.0, (2, 0.1)), 5.0 + libm::log(10.0), epsilon = 1e-9);
        assert_relative_eq!(less_copies(-9.0, -9.0, (2, 0.1)), -9.0 - libm::log(0.9), epsilon = 1e-4);
        assert_eq!(less_copies(2.5, 2.5, (3, 0.0)), 2.5);
    }
}
