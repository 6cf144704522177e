//! Which renderer to use.

use super::reference::ReferenceRenderer;
use super::wgpu::WgpuRenderer;
use super::{RenderError, Renderer};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The renderer that a user asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RendererChoice {
    /// wgpu, or the reference where there is no Vulkan driver.
    #[default]
    Auto,
    /// wgpu or an error.
    Wgpu,
    /// The reference.
    Reference,
}

/// A name that is no renderer's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown renderer `{0}`: expected `auto`, `wgpu` or `reference`")]
pub struct UnknownRenderer(
    /// The name.
    pub String,
);

impl FromStr for RendererChoice {
    type Err = UnknownRenderer;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "auto" => Ok(Self::Auto),
            "wgpu" => Ok(Self::Wgpu),
            "reference" => Ok(Self::Reference),
            _ => Err(UnknownRenderer(name.into())),
        }
    }
}

impl fmt::Display for RendererChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Wgpu => "wgpu",
            Self::Reference => "reference",
        })
    }
}

/// A renderer ready to draw.
pub struct Opened {
    /// The renderer.
    pub renderer: Box<dyn Renderer>,
    /// A line for the user where [`RendererChoice::Auto`] fell back to the reference.
    pub notice: Option<String>,
}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Opened")
            .field("renderer", &self.renderer.info())
            .field("notice", &self.notice)
            .finish()
    }
}

/// Opens the renderer of choice.
pub fn open(choice: RendererChoice) -> Result<Opened, RenderError> {
    let wgpu = || WgpuRenderer::new().map(|renderer| Opened { renderer: Box::new(renderer), notice: None });
    let reference = |notice| Opened { renderer: Box::new(ReferenceRenderer::new()), notice };
    match choice {
        RendererChoice::Wgpu => wgpu(),
        RendererChoice::Reference => Ok(reference(None)),
        RendererChoice::Auto => Ok(wgpu().unwrap_or_else(|error| reference(Some(notice(&error))))),
    }
}

fn notice(error: &RenderError) -> String {
    let reason = match error {
        RenderError::NoAdapter { .. } => {
            "no Vulkan driver found (install `mesa-vulkan-drivers` to render with wgpu)".into()
        }
        other => other.to_string(),
    };
    format!("{reason}: rendering with the plain-Rust reference renderer")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for choice in [RendererChoice::Auto, RendererChoice::Wgpu, RendererChoice::Reference] {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        assert!("Vulkan".parse::<RendererChoice>().unwrap_err().to_string().contains("`Vulkan`"));
    }

    #[test]
    fn the_notice_names_the_package() {
        let line = notice(&RenderError::NoAdapter { detail: "no loader\nat all".into() });
        assert!(line.contains("mesa-vulkan-drivers") && !line.contains('\n'), "{line}");
    }

    #[test]
    fn the_reference_opens_everywhere() {
        let opened = open(RendererChoice::Reference).unwrap();
        assert_eq!(opened.renderer.info().renderer, "reference");
        assert_eq!(opened.notice, None);
    }
}
