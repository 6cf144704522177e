//! What results were made on, and with which model: where these are the same, differences come from the code, as a rule (virtual machines
//! give different processors one name).

use crate::result::manifest::{FILE_NAME, Host, LARGEST_FILE, Manifest, Renderer};
use serde::Deserialize;
use std::path::Path;
use vantage_dataset::store::read_regular;

/// The part of a manifest that tells what computed and rendered, and which model was asked.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Machine {
    renderer: Renderer,
    host: Host,
    model_hash: Option<String>,
}

impl Machine {
    /// That of the manifest in `folder`; `None` where there is none that can be read.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&read_regular(&folder.join(FILE_NAME), LARGEST_FILE).ok()?).ok()
    }

    /// That of a manifest.
    pub fn of(manifest: &Manifest) -> Self {
        let Manifest { renderer, host, model_hash, .. } = manifest.clone();
        Self { renderer, host, model_hash }
    }

    /// A sentence on what the baseline was made on, as seen from here.
    pub fn compared_with(&self, baseline: Option<&Self>) -> String {
        let Some(baseline) = baseline else {
            return "The baseline has no manifest: what it was made on is not known.\n".to_owned();
        };
        let cpu = |machine: &Self| {
            let name = machine.host.cpu.clone().unwrap_or_else(|| "an unknown processor".to_owned());
            format!("{name} ({})", machine.host.arch)
        };
        let renderer = |machine: &Self| {
            let Renderer { name, adapter, driver } = &machine.renderer;
            [Some(name), adapter.as_ref(), driver.as_ref()]
                .into_iter()
                .flatten()
                .cloned()
                .collect::<Vec<_>>()
                .join(", ")
        };
        let others: Vec<String> = [cpu as fn(&Self) -> String, renderer]
            .into_iter()
            .filter(|part| part(self) != part(baseline))
            .map(|part| format!("{}, here {}", part(baseline), part(self)))
            .collect();
        let model = match self.model_hash == baseline.model_hash {
            true => "",
            false => "The baseline was made with another model: what differs may come from that alone.\n",
        };
        if others.is_empty() && !model.is_empty() {
            model.to_owned()
        } else if others.is_empty() {
            "The baseline was made on an equally named processor, with the same renderer and driver: what differs comes from the code, or from \
             a processor that rounds otherwise.\n"
                .to_owned()
        } else {
            format!("{model}The baseline was made on {}: scores may differ by rounding.\n", others.join("; "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    #[test]
    fn another_processor_or_driver_is_told() {
        let mut manifest = Manifest::new("abc", &[Seed(0)]);
        manifest.renderer = Renderer {
            name: "wgpu".to_owned(),
            adapter: Some("llvmpipe".to_owned()),
            driver: Some("Mesa 22".to_owned()),
        };
        let folder = tempfile::tempdir().unwrap();
        let here = Machine::of(&manifest);
        assert_eq!(Machine::read(folder.path()), None);
        assert!(here.compared_with(None).contains("no manifest"));
        std::fs::write(folder.path().join(FILE_NAME), manifest.to_json().unwrap()).unwrap();
        let baseline = Machine::read(folder.path()).unwrap();
        assert_eq!(baseline, here);
        assert!(here.compared_with(Some(&baseline)).contains("comes from the code"));
        manifest.model_hash = Some("def".to_owned());
        assert!(Machine::of(&manifest).compared_with(Some(&baseline)).contains("another model"));
        manifest.model_hash = None;
        manifest.renderer.driver = Some("Mesa 23".to_owned());
        manifest.host.cpu = Some("Zilog Z80".to_owned());
        let said = Machine::of(&manifest).compared_with(Some(&baseline));
        assert!(
            said.contains("Mesa 22, here wgpu, llvmpipe, Mesa 23") && said.contains("Zilog Z80"),
            "{said}"
        );
    }
}
