//! Words that options choose from.

use clap::{Command, CommandFactory, ValueEnum};
use serde::Serialize;
use vantage_dataset::Split;
use vantage_sim::render::choice::RendererChoice as Renderers;

/// How a dataset is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DatasetFormat {
    /// `<seed>/`: everything, in our own layout.
    Vantage,
    /// `tum/<seed>/`: the true trajectory and that of odometry alone, for evo.
    Tum,
    /// `g2o/<seed>.g2o`: odometry as a pose graph, for GTSAM and g2o.
    G2o,
    /// `webdataset/`: crops with poses and labels in tar shards.
    Webdataset,
    /// `parquet/`: the same as a Hugging Face image dataset.
    Parquet,
    /// `bop/`: images, depth, masks, poses and meshes in the layout of the BOP challenge.
    Bop,
    /// `bop-webdataset/`: the same in the tar shards that BOP defines.
    BopWebdataset,
    /// `bigbird/`: images of a turntable, in the layout of BigBIRD.
    Bigbird,
    /// `avd/`: images of a grid, in the layout of the Active Vision dataset.
    Avd,
}

/// Which tables are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TablesChoice {
    /// One of trajectories and one of latents.
    #[default]
    Short,
    /// All that are written, and azimuths by family.
    All,
}

/// A set of instances; no two share one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SplitChoice {
    /// To train on.
    Train,
    /// To tune on.
    Validation,
    /// That which is scored.
    #[default]
    Test,
}

impl From<SplitChoice> for Split {
    fn from(choice: SplitChoice) -> Self {
        match choice {
            SplitChoice::Train => Split::Train,
            SplitChoice::Validation => Split::Validation,
            SplitChoice::Test => Split::Test,
        }
    }
}

/// What renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RendererChoice {
    /// wgpu where there is a Vulkan driver, the reference renderer otherwise.
    #[default]
    Auto,
    /// wgpu; an error where there is no Vulkan driver.
    Wgpu,
    /// The plain-Rust renderer, the same bits on any processor.
    Reference,
}

impl From<RendererChoice> for Renderers {
    fn from(choice: RendererChoice) -> Self {
        match choice {
            RendererChoice::Auto => Renderers::Auto,
            RendererChoice::Wgpu => Renderers::Wgpu,
            RendererChoice::Reference => Renderers::Reference,
        }
    }
}

/// A layout of real data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ImportLayout {
    /// BigBIRD: objects on a turntable.
    Bigbird,
    /// Active Vision: homes on a grid.
    Avd,
    /// BOP: images with the poses of objects, one folder a scene.
    Bop,
    /// Photographs named by object and azimuth, as COIL-100's.
    Folder,
}

/// What a report is written as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ReportFormat {
    /// One page with tables and pictures.
    #[default]
    Html,
    /// The tables.
    Markdown,
    /// The tables, for the package `booktabs`.
    Latex,
}

/// The name of a command, for [`super::ManArgs`].
pub(super) fn command_name(name: &str) -> Result<String, String> {
    let commands = super::Cli::command();
    let names: Vec<&str> = commands.get_subcommands().map(Command::get_name).collect();
    if names.contains(&name) {
        return Ok(name.to_owned());
    }
    Err(format!("there is no such command; expected one of {}", names.join(", ")))
}

/// Degrees above the horizon from which an azimuth can be told.
pub(super) fn elevation(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees.abs() <= 85.0 => Ok(degrees),
        _ => Err("expected degrees from -85 to 85".to_owned()),
    }
}

/// Sizes of an object: from the surface of its sphere to where 5 cm are as far off as scenes have views, 50 m.
pub(super) fn sizes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(sizes) if (0.5..=1000.0).contains(&sizes) => Ok(sizes),
        _ => Err("expected sizes of the object from 0.5 to 1000".to_owned()),
    }
}

/// A number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a number above 0".to_owned()),
    }
}
