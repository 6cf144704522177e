//! Results: numbers with their origin, and the files that hold them.

pub mod better;
pub mod bootstrap;
pub mod distribution;
pub mod effect;
pub mod error;
pub mod folder;
pub mod gain;
pub mod gains_text;
pub mod grid;
pub mod holm;
pub mod kind;
pub mod made_folders;
pub mod manifest;
pub mod metric;
pub mod outcome;
pub mod output_folder;
pub mod paired;
pub mod power;
pub mod report;
pub mod results_file;
pub mod run;
pub mod standing;
pub mod statistics;
pub mod step_errors;
pub mod step_times;
pub mod summary_text;
pub mod table;
pub mod table_text;
pub mod unit;
pub mod wilcoxon;

pub use vantage_formats::trajectory;
