//! `README.md`: the card that tells Hugging Face, and people, what the files hold.

use super::columns::COLUMNS;
use crate::crops::options::CropOptions;
use crate::shard::LayoutManifest;
use std::fmt::Write;
use vantage_dataset::Split;
use vantage_dataset::crop::CROP_SIDE;

/// The card of a dataset whose shards are all written.
pub(crate) fn card(options: &CropOptions, manifest: &LayoutManifest) -> String {
    let mut text = String::from("---\n");
    let mut line = |line: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{line}");
    };
    line(format_args!("license: {}", quoted(&options.licence)));
    line(format_args!("pretty_name: {}", quoted(&options.name)));
    line(format_args!("dataset_info:"));
    line(format_args!("  features:"));
    for column in &COLUMNS {
        line(format_args!("  - name: {}\n    {}", column.name, column.kind.yaml()));
    }
    let splits = [Split::Train, Split::Validation, Split::Test];
    let shards = |split: Split| manifest.shards.iter().filter(move |shard| shard.split == split);
    let splits: Vec<_> = splits.into_iter().filter(|&split| shards(split).next().is_some()).collect();
    line(format_args!("  splits:"));
    for &split in &splits {
        let bytes: u64 = shards(split).map(|shard| shard.content.bytes).sum();
        let samples: u64 = shards(split).map(|shard| shard.samples).sum();
        let name = split.name();
        line(format_args!("  - name: {name}\n    num_bytes: {bytes}\n    num_examples: {samples}"));
    }
    let bytes: u64 = manifest.shards.iter().map(|shard| shard.content.bytes).sum();
    line(format_args!("  download_size: {bytes}\n  dataset_size: {bytes}"));
    line(format_args!("configs:\n- config_name: default\n  data_files:"));
    for &split in &splits {
        let name = split.name();
        line(format_args!("  - split: {name}\n    path: data/{name}-*.parquet"));
    }
    line(format_args!("---\n\n# {}\n", options.name));
    line(format_args!("{} crops of {CROP_SIDE} x {CROP_SIDE} pixels.\n", manifest.samples));
    line(format_args!("| column | meaning |\n|---|---|"));
    COLUMNS.iter().for_each(|column| line(format_args!("| `{}` | {} |", column.name, column.meaning)));
    let mut licences: Vec<_> =
        manifest.objects.values().filter_map(|object| object.licence.as_deref()).collect();
    licences.sort_unstable();
    licences.dedup();
    if !licences.is_empty() {
        line(format_args!("\nLicences of the meshes:\n"));
        licences.iter().for_each(|licence| line(format_args!("- {licence}")));
    }
    text
}

/// A YAML string in double quotes.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
