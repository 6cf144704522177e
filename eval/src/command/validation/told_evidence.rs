//! What validation crops at their true viewpoints tell of a model's errors, as tables.

use super::evidence::{
    CONCENTRATIONS, Gains, PAIRINGS, SCALE_SPREADS, ScaleGains, TrueViews, VisitGains, pair_gains,
};
use super::print;
use crate::command::error::BenchError;
use std::io::Write;
use vantage_model::{ObservationModel, PairModel};
use vantage_slam::AzimuthDiscrepancy;
use vantage_slam::discrepancy::Discrepant;

/// Prints by how much azimuths are off and, with that, how wide the noise is; the discrepancy that fits best, `None` where the model has no finite answer.
pub fn fitted_discrepancy(
    objects: &[TrueViews],
    model: &dyn ObservationModel,
    stdout: &mut impl Write,
) -> Result<Option<AzimuthDiscrepancy>, BenchError> {
    let gains = Gains::of(objects, model).unwrap_or_default();
    let Some((fitted, gain)) = Gains::most(&gains) else { return Ok(None) };
    writeln!(
        stdout,
        "azimuths that are off: nats a view above none, each view by itself and smoothly by concentration"
    )?;
    let concentrations = CONCENTRATIONS.map(|concentration| concentration.to_string());
    let columns: Vec<&str> =
        ["Off by [deg]", "white"].into_iter().chain(concentrations.iter().map(String::as_str)).collect();
    let cells = |of: &Gains| {
        let gains = std::iter::once(&of.white).chain(&of.smooth).map(|gain| format!("{gain:.3}"));
        std::iter::once(of.sigma_deg.to_string()).chain(gains).collect()
    };
    print(stdout, &columns, gains.iter().map(cells).collect())?;
    let AzimuthDiscrepancy { sigma, concentration } = fitted;
    writeln!(
        stdout,
        "azimuth off by {:.1} degrees with a concentration of {concentration}: {gain:.3} nats a view more probable than on the spot\n",
        sigma.to_degrees()
    )?;
    if let Some([alone, both]) = VisitGains::of(objects, model, &fitted) {
        writeln!(
            stdout,
            "covariances of their harmonics by expectation maximization; {:.1} visits an object",
            both.visits
        )?;
        let cells = |name: &str, of: &VisitGains, which: usize| {
            let deviations = of.deviations_deg[which].map(|deviation| format!("{deviation:.2}"));
            std::iter::once(name.to_owned()).chain([format!("{:.3}", of.gain)]).chain(deviations).collect()
        };
        let rows = vec![
            cells("object alone", &alone, 0),
            cells("object, with visits", &both, 0),
            cells("visits", &both, 1),
        ];
        let harmonics = ["constant [deg]", "1", "2", "3", "4", "5", "6"];
        let columns: Vec<&str> = ["Of", "Nats a view"].into_iter().chain(harmonics).collect();
        print(stdout, &columns, rows)?;
        writeln!(stdout)?;
    }
    if let Some(gains) = ScaleGains::of(objects, &Discrepant::new(model, &fitted)) {
        let (factor, gain) = gains.common;
        writeln!(
            stdout,
            "with it, noise of all objects times {factor:.2}: {gain:.3} nats a view above none"
        )?;
        writeln!(
            stdout,
            "times a factor of each object's own about that, by the spread of its logarithm: nats a view above none"
        )?;
        let spreads = SCALE_SPREADS.map(|spread| spread.to_string());
        let columns: Vec<&str> = spreads.iter().map(String::as_str).collect();
        print(stdout, &columns, vec![gains.own.iter().map(|gain| format!("{gain:.3}")).collect()])?;
        writeln!(stdout)?;
    }
    Ok(Some(fitted))
}

/// Prints what pairings gain.
pub fn print_pairings(
    objects: &[TrueViews],
    model: &dyn PairModel,
    stdout: &mut impl Write,
) -> Result<(), BenchError> {
    writeln!(stdout, "nats a view above those by the latent alone, by what each view is given")?;
    let gain = |gain: Option<f64>| gain.map_or("-".to_owned(), |gain| format!("{gain:.3}"));
    let cells = PAIRINGS.iter().zip(pair_gains(objects, model));
    let rows = cells.map(|((name, _), of)| vec![(*name).to_owned(), gain(of)]).collect();
    print(stdout, &["Pairing", "Nats a view"], rows)?;
    Ok(writeln!(stdout)?)
}
