//! The graphics device.

use super::super::{RenderError, RendererInfo};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// After this long a submission counts as hung.
const PATIENCE: Duration = Duration::from_secs(300);

/// An opened device.
#[derive(Debug)]
pub(super) struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// The first thing that went wrong.
    fault: Arc<OnceLock<String>>,
}

impl Gpu {
    /// Opens the adapter named by `WGPU_ADAPTER_NAME` (a part of its name will do), or else the one that wgpu prefers.
    pub fn open() -> Result<Self, RenderError> {
        pollster::block_on(async {
            let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
                backends: wgpu::Backends::VULKAN,
                ..wgpu::InstanceDescriptor::new_without_display_handle()
            });
            let adapter = choose(&instance).await?;
            let info = adapter.get_info();
            let (device, queue) = adapter
                .request_device(&wgpu::DeviceDescriptor {
                    memory_hints: wgpu::MemoryHints::MemoryUsage,
                    ..Default::default()
                })
                .await
                .map_err(|error| RenderError::Device {
                    adapter: info.name.clone(),
                    detail: error.to_string(),
                })?;
            let fault = Arc::new(OnceLock::new());
            let complaints = Arc::clone(&fault);
            device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                complaints.get_or_init(|| error.to_string());
            }));
            let complaints = Arc::clone(&fault);
            device.set_device_lost_callback(move |reason, message| {
                complaints.get_or_init(|| format!("device lost ({reason:?}): {message}"));
            });
            Ok(Self { device, queue, info, fault })
        })
    }

    pub fn info(&self) -> RendererInfo {
        let driver = format!("{} {}", self.info.driver, self.info.driver_info);
        RendererInfo {
            renderer: "wgpu".into(),
            adapter: self.info.name.clone(),
            driver: driver.trim().into(),
        }
    }

    /// The first fault, if any.
    pub fn check(&self) -> Result<(), RenderError> {
        self.fault.get().map_or(Ok(()), |detail| Err(self.failed(detail.clone())))
    }

    /// A failure that is none of the faults.
    pub fn failed(&self, detail: impl Into<String>) -> RenderError {
        RenderError::Device { adapter: self.info.name.clone(), detail: detail.into() }
    }

    /// Blocks until a submission and the mapping of what it copied are done.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        let until_done = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(PATIENCE) };
        // poll panics, with no lock held, when the device is lost while it waits.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(until_done)));
        self.check()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(self.failed(error.to_string())),
            Err(_) => Err(self.failed("device lost while waiting for it")),
        }
    }
}

async fn choose(instance: &wgpu::Instance) -> Result<wgpu::Adapter, RenderError> {
    let Ok(wanted) = std::env::var("WGPU_ADAPTER_NAME") else {
        let chosen = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await;
        return chosen.map_err(|error| RenderError::NoAdapter { detail: error.to_string() });
    };
    let mut names = Vec::new();
    for adapter in instance.enumerate_adapters(wgpu::Backends::VULKAN).await {
        let name = adapter.get_info().name;
        if name.to_lowercase().contains(&wanted.to_lowercase()) {
            return Ok(adapter);
        }
        names.push(name);
    }
    Err(RenderError::NoAdapter {
        detail: format!("none is named like WGPU_ADAPTER_NAME={wanted}; there are: [{}]", names.join(", ")),
    })
}
