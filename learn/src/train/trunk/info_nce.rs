//! Metric learning by the InfoNCE loss of van den Oord et al. 2018, in the form of Khosla et al. 2020 where an instance has more than two
//! views: alone it is a rival of the paper's models, and a trunk may learn it beside viewpoints.

use crate::train::network::exponential::log_softmax;
use crate::train::network::rows::table;
use burn::tensor::{Device, Tensor};

/// What similarities are divided by.
const TEMPERATURE: f64 = 0.1;
/// Added to the similarity of rows of one view, so that a view is never taken for its own partner.
const FORBIDDEN: f32 = -1e4;

/// What a row is an embedding of. Rows of one instance are partners; rows of one view are not compared.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) view: usize,
    pub(crate) instance: usize,
}

/// [`loss`] of `2 n` rows of different views, of which each has one partner, `n` rows away.
pub(crate) fn loss_of_pairs(embedded: Tensor<2>, device: &Device) -> Tensor<1> {
    let count = embedded.dims()[0] / 2;
    let rows: Vec<Row> = (0..2 * count).map(|view| Row { view, instance: view % count }).collect();
    loss(embedded, &rows, device)
}

/// Cross-entropy of finding, for each row, its partners among all others, by cosine similarity; each is as right as another, as in
/// Eq. 2 of Khosla et al. 2020. Every row has to have one.
pub(crate) fn loss(embedded: Tensor<2>, rows: &[Row], device: &Device) -> Tensor<1> {
    let count = rows.len();
    let square = |entry: &dyn Fn(&Row, &Row) -> f32| -> Vec<f32> {
        rows.iter().flat_map(|row| rows.iter().map(move |other| entry(row, other))).collect()
    };
    let same = square(&|row, other| if row.view == other.view { FORBIDDEN } else { 0.0 });
    let mut partners =
        square(&|row, other| f32::from(u8::from(row.instance == other.instance && row.view != other.view)));
    for row in partners.chunks_exact_mut(count) {
        let all: f32 = row.iter().sum();
        row.iter_mut().for_each(|share| *share /= all);
    }
    let unit = normalized(embedded);
    let similarity = unit.clone().matmul(unit.transpose()) / TEMPERATURE + table(same, count, device);
    (log_softmax(similarity) * table(partners, count, device)).sum_dim(1).mean().neg()
}

/// Rows of unit length.
pub(crate) fn normalized(rows: Tensor<2>) -> Tensor<2> {
    let length = (rows.clone().square().sum_dim(1) + 1e-12).sqrt();
    rows / length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::run::scalar;

    #[test]
    fn partners_that_agree_cost_little_and_ones_that_do_not_cost_much() {
        let device = Device::flex();
        let rows = |numbers: &[f32]| table(numbers.to_vec(), 4, &device);
        let right = scalar(&loss_of_pairs(rows(&[1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 3.0]), &device));
        let wrong = scalar(&loss_of_pairs(rows(&[1.0, 0.0, 0.0, 1.0, 0.0, 2.0, 3.0, 0.0]), &device));
        assert!(right < 1e-3 && wrong > 9.0, "{right} {wrong}");
        let blind = scalar(&loss_of_pairs(rows(&[1.0; 8]), &device));
        assert!((blind - 3f64.ln()).abs() < 1e-4, "{blind}");
    }

    #[test]
    fn all_views_of_an_instance_are_partners_and_a_view_is_not_its_own() {
        let device = Device::flex();
        let cost = |angles: [f32; 6], rows: [(usize, usize); 6]| {
            let numbers = angles.iter().flat_map(|angle| [libm::cosf(*angle), libm::sinf(*angle)]).collect();
            let rows = rows.map(|(view, instance)| Row { view, instance });
            scalar(&loss(table(numbers, 6, &device), &rows, &device))
        };
        let three_each = [(0, 0), (1, 0), (2, 0), (3, 1), (4, 1), (5, 1)];
        let right = cost([0.0, 0.0, 0.0, 3.0, 3.0, 3.0], three_each);
        assert!((right - 2f64.ln()).abs() < 1e-4, "two partners are found as well as each other: {right}");
        let stray = cost([0.0, 0.0, 3.0, 3.0, 3.0, 3.0], three_each);
        assert!(stray > right + 3.0, "{stray}");
        let twice = [(0, 0), (1, 0), (1, 0), (3, 1), (4, 1), (4, 1)];
        let once = cost([0.0, 0.0, 0.0, 3.0, 3.0, 3.0], twice);
        assert!(
            (once - 2.0 / 6.0 * 2f64.ln()).abs() < 1e-4,
            "only the two single views have two partners: {once}"
        );
    }
}
