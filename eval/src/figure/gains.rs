//! `gains.svg`: what methods change of the reference's error, seed by seed.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, svg};
use crate::result::metric::Metric;
use crate::result::paired::Paired;
use crate::result::statistics::Mean;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vantage_dataset::Seed;

const FIGURE: &str = "gains";
const WIDTH: u32 = 900;
/// Height of a method's panel.
const PANEL: u32 = 380;
/// Above which number of seeds their names would touch.
const NAMED: usize = 60;

/// A panel for each method: a bar a seed, from the best to the worst, with the mean and its 95% interval.
///
/// `scene` and `reference` are for the titles; differences are of the ATE, metres.
pub fn gains_svg(scene: &str, reference: &str, methods: &[(&str, Paired)]) -> Result<String, FigureError> {
    if methods.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE });
    }
    svg(FIGURE, (WIDTH, PANEL * methods.len() as u32), |area| {
        for (panel, (method, paired)) in area.split_evenly((methods.len(), 1)).iter().zip(methods) {
            let title = format!("{scene}: ATE of {method} less that of {reference}, seed by seed");
            bars(panel, &title, paired)?;
        }
        Ok(())
    })
}

fn bars(panel: &Area<'_>, title: &str, paired: &Paired) -> Drawn {
    let sorted = paired.sorted();
    let mean = paired.mean();
    let (low, high) = limits(&sorted, mean);
    let seeds = sorted.len() as f64;
    let mut chart = ChartBuilder::on(panel)
        .caption(title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(30)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..seeds, low..high)?;
    let better = format!("{} of {} seeds are better, below 0", paired.better(), paired.seeds());
    chart
        .configure_mesh()
        .x_desc(format!("seeds by their difference; {better}"))
        .y_desc("difference of the ATE [m]")
        .disable_x_mesh()
        .x_labels(0)
        // Zero without sign.
        .y_label_formatter(&|difference| format!("{:?}", (difference * 1e6).round() / 1e6 + 0.0))
        .max_light_lines(1)
        .draw()?;
    for (place, (seed, difference)) in sorted.iter().enumerate() {
        let (left, color) = (place as f64, color(usize::from(*difference < 0.0)));
        let bar = [(left + 0.1, 0.0), (left + 0.9, *difference)];
        chart.draw_series([Rectangle::new(bar, color.mix(0.8).filled())])?;
        let side = if *difference < 0.0 { VPos::Top } else { VPos::Bottom };
        let style = ("sans-serif", 10).into_font().color(&BLACK.mix(0.7)).pos(Pos::new(HPos::Center, side));
        let name = if sorted.len() <= NAMED { seed.0.to_string() } else { String::new() };
        chart.draw_series([Text::new(name, (left + 0.5, *difference), style)])?;
    }
    chart.draw_series(LineSeries::new([(0.0, 0.0), (seeds, 0.0)], BLACK.stroke_width(1)))?;
    let Some(mean) = mean else { return Ok(()) };
    let half = mean.half_width.unwrap_or_default();
    let interval = [(0.0, mean.mean - half), (seeds, mean.mean + half)];
    chart.draw_series([Rectangle::new(interval, BLACK.mix(0.15).filled())])?;
    chart.draw_series(LineSeries::new([(0.0, mean.mean), (seeds, mean.mean)], BLACK.stroke_width(2)))?;
    let width = mean.half_width.map(|half| format!(" +- {} (95%)", Metric::Ate.display(half)));
    let text = format!("mean {}{} m", Metric::Ate.display(mean.mean), width.unwrap_or_default());
    let style = ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Top));
    chart.draw_series([Text::new(text, (seeds * 0.01, high), style)])?;
    Ok(())
}

/// From below the least to above the largest of bars, zero and interval, with room for the names of seeds.
fn limits(sorted: &[(Seed, f64)], mean: Option<Mean>) -> (f64, f64) {
    let (low, high) = mean.and_then(|mean| mean.interval()).unwrap_or_default();
    let differences = || sorted.iter().map(|(_, difference)| *difference);
    let low = differences().fold(low.min(0.0), f64::min);
    let high = differences().fold(high.max(0.0), f64::max);
    let margin = ((high - low) * 0.1).max(1e-6);
    (low - margin, high + margin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::{METHODS, runs, table};

    #[test]
    fn every_seed_has_a_bar_with_its_name_and_the_mean_is_told() {
        let table = table(runs()).unwrap();
        let paired = |method| (method, table.paired(method, Metric::Ate).unwrap());
        let svg = gains_svg("a<b", "geometric", &[paired(METHODS[2])]).unwrap();
        let rectangles = |svg: &str| svg.matches("<rect").count();
        // The ground, four bars and the interval.
        assert_eq!(rectangles(&svg), 1 + 4 + 1, "{svg}");
        for text in
            ["a&lt;b: ATE of viewpoint_dependent less that of geometric", "mean -0.1000 +- 0.0000 (95%) m"]
        {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert!(svg.contains("4 of 4 seeds are better"), "{svg}");
        let both = gains_svg("s", "geometric", &[paired(METHODS[0]), paired(METHODS[2])]).unwrap();
        assert_eq!(rectangles(&both), 1 + 2 * 5);
        assert_eq!(both, gains_svg("s", "geometric", &[paired(METHODS[0]), paired(METHODS[2])]).unwrap());
    }

    #[test]
    fn one_seed_has_no_interval_and_no_method_no_picture() {
        let one = table(runs()).unwrap().on(&[Seed(1)]);
        let paired = one.paired(METHODS[2], Metric::Ate).unwrap();
        let svg = gains_svg("s", "geometric", &[("mine", paired)]).unwrap();
        assert!(svg.contains("mean -0.1000 m") && !svg.contains("+-"), "{svg}");
        assert!(matches!(gains_svg("s", "geometric", &[]), Err(FigureError::Empty { .. })));
    }
}
