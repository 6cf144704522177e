//! Which renderer to use.

use super::reference::ReferenceRenderer;
use super::wgpu::WgpuRenderer;
use super::{RenderError, Renderer};

/// The renderer that a user asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RendererChoice {
    /// wgpu, or the reference where there is no Vulkan driver.
    Auto,
    /// wgpu or an error.
    Wgpu,
    /// The reference.
    Reference,
}

/// A renderer ready to draw.
pub struct Opened {
    /// The renderer.
    pub renderer: Box<dyn Renderer>,
    /// A line for the user where [`RendererChoice::Auto`] fell back to the reference.
    pub notice: Option<String>,
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
