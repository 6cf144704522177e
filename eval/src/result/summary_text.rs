//! What a run says first: a table of trajectories, one of latents, and the answer in words.

use super::effect::Effect;
use super::gain::Gain;
use super::gains_text::p_text;
use super::grid::{Style, UNDEFINED, draw_in_parts};
use super::holm::holm;
use super::metric::Metric;
use super::table::Table;
use super::table_text::{mean_text, over, runs_text};
use crate::scene_file::row_name::is_learned;

/// Seeds whose signed ranks can be below 0.05.
const FEWEST: usize = 6;

/// Columns that both tables fit into; on a narrower terminal they come in parts.
const WIDTH: u16 = 100;

/// Trajectories: error, paired difference to the reference, seeds that are better, heading.
pub fn trajectories(table: &Table, style: Style) -> String {
    let mut head = vec!["Method".to_owned(), "Runs".to_owned(), "ATE [m] ↓".to_owned()];
    if let Some(reference) = table.reference() {
        head.extend([format!("Difference to\n{reference} [m] ↓"), "Seeds\nbetter".to_owned()]);
    }
    head.push("Heading\n[deg] ↓".to_owned());
    let row = |method: &String| {
        let mean = |metric| mean_of(table, method, metric);
        let mut row = vec![method.clone(), runs_text(table, method), mean(Metric::Ate)];
        if table.reference().is_some() {
            let paired = table.paired(method, Metric::Ate);
            let runs = table.seeds().len();
            let difference = paired.as_ref().map(|paired| mean_text(Metric::Ate, paired.mean(), runs));
            let better = paired.map(|paired| format!("{} of {}", paired.better(), paired.seeds()));
            row.extend([difference, better].map(|text| text.unwrap_or_else(|| UNDEFINED.to_owned())));
        }
        row.push(mean(Metric::Heading));
        row
    };
    let rows: Vec<Vec<String>> = table.methods().iter().map(row).collect();
    let drawn = draw_in_parts(style.within(WIDTH), 1, &head, &rows);
    format!("Trajectories, {}\n{drawn}\n", over(table))
}

/// Latents of single views: clusters, retrieval, azimuth, class from a few tags.
pub fn latents(latents: &Table, classes: &Table, style: Style) -> String {
    let head =
        ["Method", "ARI ↑", "Recall@1,\nother light ↑", "Azimuth,\nmedian [deg] ↓", "Class by\n10 tags ↑"];
    let columns = [
        (latents, Metric::Ari),
        (latents, Metric::RecallAt1AcrossLight),
        (latents, Metric::ViewpointMedian),
        (classes, Metric::NearestOf10),
    ];
    let row = |method: &String| {
        let cells = columns.iter().map(|&(table, metric)| mean_of(table, method, metric));
        std::iter::once(method.clone()).chain(cells).collect()
    };
    let rows: Vec<Vec<String>> = latents.methods().iter().map(row).collect();
    let drawn = draw_in_parts(style.within(WIDTH), 1, &head.map(str::to_owned), &rows);
    format!("Latents of single views of unseen objects, {}\n{drawn}\n", over(latents))
}

/// [`answer`] of every learned row that has one.
pub fn answers(table: &Table) -> Vec<String> {
    let learned = table.methods().iter().filter(|method| is_learned(method));
    learned.filter_map(|method| answer(table, method)).collect()
}

/// What a method does to the reference's ATE, as far as the BCa interval of the paired differences, the seeds' agreement and their signed
/// ranks tell; `None` without an interval.
pub fn answer(table: &Table, method: &str) -> Option<String> {
    let gain = Gain::of(&table.paired(method, Metric::Ate)?)?;
    let (reference, metres) = (table.reference()?, |value: f64| Metric::Ate.display(value));
    if gain.seeds < FEWEST {
        let seeds =
            if gain.seeds == 1 { "One seed is".to_owned() } else { format!("{} seeds are", gain.seeds) };
        return Some(format!("{seeds} too few to tell {method} from {reference}."));
    }
    let (low, high) = gain.interval?;
    let counted = format!("{} of {} seeds are better", gain.better, gain.seeds);
    if low <= 0.0 && high >= 0.0 {
        return Some(format!(
            "{method} neither lowers nor raises the mean ATE of {reference} for certain: the 95% BCa interval of the \
             difference, {} to {} m, holds 0; {counted}.",
            metres(low),
            metres(high)
        ));
    }
    let (least, most) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
    let by = metres(gain.mean.mean.abs());
    let interval = format!("(95% BCa interval {} to {} m)", metres(least), metres(most));
    let p = adjusted_p(table, method)?;
    let verb = match Effect::of(&gain, Some(p)) {
        Effect::Lowers => "lowers",
        Effect::Raises => "raises",
        Effect::Undecided => {
            let comparative = if high < 0.0 { "lower" } else { "higher" };
            let but = match gain.seeds_agree {
                true => format!("the seeds' signed ranks may be chance (p = {})", p_text(p)),
                false => "the seeds disagree".to_owned(),
            };
            return Some(format!(
                "{method} is not told apart from {reference}: its mean ATE is {by} m {comparative} {interval}, but {but}; {counted}, \
                 and the median difference is {} m.",
                metres(gain.median)
            ));
        }
    };
    Some(format!("{method} {verb} the mean ATE of {reference} by {by} m {interval}; {counted}."))
}

/// Wilcoxon's p-value of a method's ATE, adjusted over it and the learned rows; `None` where it never differs from the reference's.
fn adjusted_p(table: &Table, method: &str) -> Option<f64> {
    let family = table.methods().iter().filter(|row| *row == method || is_learned(row));
    let (rows, p): (Vec<&String>, Vec<f64>) =
        family.filter_map(|row| Some((row, table.paired(row, Metric::Ate)?.p()?))).unzip();
    rows.iter().position(|row| *row == method).map(|place| holm(&p)[place])
}

fn mean_of(table: &Table, method: &str, metric: Metric) -> String {
    let cell = table.cell(method, metric);
    mean_text(metric, cell.mean, cell.runs)
}

#[cfg(test)]
mod tests {
    use super::super::run::{Outcome, Run};
    use super::super::table::tests::{METHODS, run, runs, table};
    use super::*;
    use vantage_dataset::Seed;

    /// Trajectories of as many seeds as there are differences of the learned ATE to the reference's.
    fn differing(differences: &[f64]) -> Table {
        let seeds: Vec<Seed> = (0..differences.len() as u64).map(Seed).collect();
        let of = |(&seed, &difference): (&Seed, &f64)| {
            [1.0, 0.5, 0.5 + difference]
                .map(|ate| (Metric::Ate, ate))
                .into_iter()
                .zip(METHODS)
                .map(move |(ate, method)| run(method, seed.0, &[ate]))
                .collect::<Vec<_>>()
        };
        let runs = seeds.iter().zip(differences).flat_map(of).collect();
        Table::new("trajectory", &METHODS, Some(METHODS[1]), &[Metric::Ate], &seeds, runs).unwrap()
    }

    fn widest(text: &str) -> usize {
        text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
    }

    #[test]
    fn trajectories_fit_their_width_and_tell_differences_and_seeds_that_are_better() {
        let wide = Style::Terminal(250);
        let text = trajectories(&table(runs()).unwrap(), wide);
        let narrow = trajectories(&table(runs()).unwrap(), Style::Terminal(60));
        assert!(widest(&narrow) <= 60 && narrow.matches(METHODS[2]).count() > 1, "{narrow}");
        let cells = |method: &str| -> Vec<String> {
            let line = text.lines().find(|line| line.contains(&format!("│ {method}"))).unwrap();
            line.split(['│', '┆'])
                .map(|cell| cell.trim().to_owned())
                .filter(|cell| !cell.is_empty())
                .collect()
        };
        assert!(widest(&text) <= 100, "{text}");
        assert_eq!(cells(METHODS[2])[3..5], ["-0.1000 +- 0.0000", "4 of 4"]);
        assert_eq!(cells(METHODS[1])[3..5], ["-", "-"]);
        let mut long = runs();
        long.iter_mut().filter(|run| run.seed == Seed(0)).for_each(|run| {
            run.outcome = Outcome::Failed("diverged".into());
            run.scores.clear();
        });
        let text = trajectories(&table(long).unwrap(), wide);
        assert!(widest(&text) <= 100 && text.contains("4 (1 failed)"), "{text}");
    }

    #[test]
    fn latents_stand_in_one_table_of_the_same_width() {
        let metrics = [Metric::Ari, Metric::RecallAt1AcrossLight, Metric::ViewpointMedian];
        let of = |name: &str, metrics: &[Metric]| {
            let row = |method: &str, seed: u64| {
                run(method, seed, &metrics.iter().map(|&metric| (metric, 0.25)).collect::<Vec<_>>())
            };
            let methods = ["viewpoint_predictive", "pixels_pca64"];
            let runs: Vec<Run> = (0..2).flat_map(|seed| methods.map(|method| row(method, seed))).collect();
            Table::new(name, &methods, Some(methods[1]), metrics, &[Seed(0), Seed(1)], runs).unwrap()
        };
        let text =
            latents(&of("latents", &metrics), &of("grounding", &[Metric::NearestOf10]), Style::Terminal(250));
        assert!(widest(&text) <= 100 && text.matches("0.250 +- 0.000").count() == 6, "{text}");
        assert!(text.contains("14.324 +- 0.000"), "degrees: {text}");
    }

    #[test]
    fn the_answer_is_that_of_the_interval() {
        let shifted = |by: [f64; 4]| {
            let mut runs = runs();
            for run in runs.iter_mut().filter(|run| run.method == METHODS[2]) {
                run.scores.insert(Metric::Ate, 0.5 + 0.1 * run.seed.0 as f64 + by[run.seed.0 as usize]);
            }
            table(runs).unwrap()
        };
        let told = |by| answer(&shifted(by), METHODS[2]).unwrap();
        let few = told([-0.1, -0.11, -0.1, -0.11]);
        assert_eq!(few, "4 seeds are too few to tell viewpoint_dependent from geometric.");
        let six = |by: f64| {
            let by: Vec<f64> = (0..6).map(|seed| by * f64::from(100 + seed % 2)).collect();
            answer(&differing(&by), METHODS[2]).unwrap()
        };
        assert!(six(-0.001).contains("lowers the mean ATE of geometric by 0.1005 m"), "{}", six(-0.001));
        assert!(six(0.001).contains("raises") && six(0.001).contains("0 of 6"), "{}", six(0.001));
        let open = answer(&differing(&[-0.1, 0.1, -0.1, 0.05, 0.1, -0.02]), METHODS[2]).unwrap();
        assert!(open.contains("holds 0") && open.contains("3 of 6 seeds are better"), "{open}");
        assert_eq!(answer(&shifted([0.0; 4]), METHODS[1]), None);
        let one = answer(&shifted([0.0; 4]).on(&[Seed(1)]), METHODS[2]).unwrap();
        assert!(one.starts_with("One seed is too few"), "{one}");
    }

    #[test]
    fn a_mean_that_few_seeds_make_is_no_gain_and_no_loss() {
        let few: Vec<f64> = (0..40).map(|seed| [0.0004, -0.0004, -0.0004, 0.0004][seed % 4]).collect();
        let with = |large: f64, seeds: usize| -> Vec<f64> {
            few.iter().enumerate().map(|(seed, small)| if seed < seeds { large } else { *small }).collect()
        };
        let told = |differences: &[f64]| answer(&differing(differences), METHODS[2]).unwrap();
        let lower = told(&with(-0.3, 6));
        assert!(
            lower.contains("is not told apart from geometric: its mean ATE is 0.0450 m lower"),
            "{lower}"
        );
        assert!(
            lower.contains("23 of 40 seeds are better, and the median difference is -0.0004 m"),
            "{lower}"
        );
        let higher = told(&with(0.3, 6));
        assert!(higher.contains("is not told apart") && higher.contains("0.0450 m higher"), "{higher}");
        assert!(told(&with(-0.3, 20)).contains("lowers"), "30 of 40 seeds agree");
    }

    #[test]
    fn more_learned_rows_ask_for_more() {
        let methods = [METHODS[1], "mine", "mine_too"];
        let row = |seed: u64| {
            let ates = [0.5, 0.4 + 0.001 * seed as f64, if seed < 3 { 0.45 } else { 0.55 }];
            methods.into_iter().zip(ates).map(move |(method, ate)| run(method, seed, &[(Metric::Ate, ate)]))
        };
        let seeds: Vec<Seed> = (0..6).map(Seed).collect();
        let runs = (0..6).flat_map(row).collect();
        let two = Table::new("trajectory", &methods, Some(METHODS[1]), &[Metric::Ate], &seeds, runs).unwrap();
        let told = answer(&two, "mine").unwrap();
        assert!(
            told.contains("may be chance (p = 0.0625); 6 of 6 seeds are better"),
            "2 times 2 in 2^6: {told}"
        );
        assert_eq!(answers(&two).len(), 2);
    }
}
