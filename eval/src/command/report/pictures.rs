//! The pictures of a result, as a page holds them: whole, and with words for those who do not see them.

use crate::command::error::BenchError;
use crate::result::output_folder::OutputError;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::Path;
use vantage_dataset::store::read_regular;

const LARGEST: u64 = 64 << 20;

/// Names of pictures in their order, with what they show.
const SHOWN: [(&str, &str); 17] = [
    (
        "gains.svg",
        "Paired differences of ATE to the geometric estimator, a bar a seed, with mean and interval",
    ),
    ("map.svg", "Gain in ATE over the cells of the map"),
    ("law.svg", "Median error of the azimuth over the number of composites that models were trained on"),
    ("summary.svg", "Gain in ATE along each axis of the map"),
    ("trajectory.svg", "Trajectories and objects from above: the truth and each estimate"),
    (
        "nees.svg",
        "Errors of poses against their covariances along the path: NEES over time with its interval",
    ),
    ("online.svg", "Errors of the newest pose after every step"),
    ("likelihood.svg", "Log-likelihood of a crop against the azimuth's offset from the truth"),
    ("crops.png", "Crops of the first objects as the detector cuts them, masked and with their surroundings"),
    (
        "latents.png",
        "Latents of single views laid out by t-SNE, a colour for each instance, with crops beside them",
    ),
    ("latents.svg", "Latents of single views laid out by t-SNE, a colour for each instance"),
    ("predictions.png", "What the decoder predicts from other viewpoints beside what is seen from them"),
    ("viewpoints.png", "Likelihood of each viewpoint given one crop"),
    (
        "worst_azimuths.png",
        "The azimuths that were told worst: the crop asked, what it was taken for, and the known view nearest to the truth",
    ),
    ("calibration.svg", "Calibration of the model's residuals"),
    ("map.png", "Gain in ATE over the cells of the map"),
    ("summary.png", "Gain in ATE along each axis of the map"),
];

/// A picture with its words.
pub(super) struct Picture {
    pub(super) name: String,
    pub(super) words: String,
    /// As the address of an image.
    pub(super) data: String,
}

/// The SVG and PNG files among a result's files, as far as they are there, those that are known first. Of one picture in both forms only
/// the SVG, which scales.
pub(super) fn pictures(folder: &Path, files: &[String]) -> Result<Vec<Picture>, BenchError> {
    let is_picture = |name: &&String| mime(name).is_some() && !name.contains(['/', '\\']);
    let names: Vec<&String> =
        files.iter().filter(is_picture).filter(|name| folder.join(name).is_file()).collect();
    let scales = |name: &str| {
        name.strip_suffix(".png")
            .is_some_and(|stem| names.contains(&&format!("{stem}.svg")) && stem != "latents")
    };
    let mut shown: Vec<String> =
        names.iter().filter(|name| !scales(name)).map(|name| (*name).clone()).collect();
    let place = |name: &str| SHOWN.iter().position(|(known, _)| *known == name).unwrap_or(SHOWN.len());
    shown.sort_by(|a, b| place(a).cmp(&place(b)).then(a.cmp(b)));
    let read = |name: String| {
        let path = folder.join(&name);
        let bytes = read_regular(&path, LARGEST).map_err(|source| OutputError { path, source })?;
        let words = SHOWN.iter().find(|(known, _)| *known == name).map_or(name.as_str(), |(_, words)| words);
        let data = format!("data:{};base64,{}", mime(&name).unwrap_or_default(), STANDARD.encode(bytes));
        Ok(Picture { words: words.to_owned(), data, name })
    };
    shown.into_iter().map(read).collect()
}

fn mime(name: &str) -> Option<&'static str> {
    match name.rsplit_once('.')?.1 {
        "svg" => Some("image/svg+xml"),
        "png" => Some("image/png"),
        _ => None,
    }
}
