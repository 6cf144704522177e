//! Where in a texture each material goes.

/// A rectangle of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rect {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

/// Cuts a square into one rectangle for each weight, of roughly proportional area.
pub(crate) fn layout(side: usize, weights: &[f64]) -> Vec<Rect> {
    let mut rects = Vec::with_capacity(weights.len());
    cut(Rect { x: 0, y: 0, width: side, height: side }, weights, &mut rects);
    rects
}

/// Halves the weights and, across its longer side, the rectangle.
fn cut(rect: Rect, weights: &[f64], rects: &mut Vec<Rect>) {
    if weights.len() < 2 {
        rects.extend(weights.iter().map(|_| rect));
        return;
    }
    let total: f64 = weights.iter().sum();
    let mut before = 0.0;
    let mut first = 0;
    while first < weights.len() - 1 && (first == 0 || before + weights[first] / 2.0 < total / 2.0) {
        before += weights[first];
        first += 1;
    }
    let (left, right) = weights.split_at(first);
    let along = rect.width.max(rect.height);
    let length = ((before / total * along as f64).round() as usize).clamp(1, along.max(2) - 1);
    let (a, b) = if rect.width >= rect.height {
        (Rect { width: length, ..rect }, Rect { x: rect.x + length, width: rect.width - length, ..rect })
    } else {
        (Rect { height: length, ..rect }, Rect { y: rect.y + length, height: rect.height - length, ..rect })
    };
    cut(a, left, rects);
    cut(b, right, rects);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_fill_the_square_without_overlap_and_by_weight() {
        for weights in [vec![1.0], vec![3.0, 1.0], vec![1.0; 7], vec![8.0, 1.0, 1.0, 4.0, 2.0]] {
            let rects = layout(128, &weights);
            let mut taken = vec![0; 128 * 128];
            for rect in &rects {
                for y in rect.y..rect.y + rect.height {
                    taken[y * 128 + rect.x..][..rect.width].iter_mut().for_each(|count| *count += 1);
                }
            }
            assert!(taken.iter().all(|&count| count == 1));
            let total: f64 = weights.iter().sum();
            for (rect, weight) in rects.iter().zip(&weights) {
                let share = (rect.width * rect.height) as f64 / (128.0 * 128.0);
                assert!((share - weight / total).abs() < 0.02, "{share} for {weight} of {total}");
            }
        }
    }
}
