//! Pictures per CPU second of both renderers, on a scene of a table, boxes and balls.
//!
//! `cargo run --release -p vantage-sim --example render_rate`

#[path = "../tests/render_scenes/mod.rs"]
mod render_scenes;

use render_scenes::{cluttered, look_at};
use std::time::Instant;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::wgpu::WgpuRenderer;
use vantage_sim::render::{RenderError, Renderer, TileShot};

const FRAMES: usize = 200;
const TILES: usize = 4000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    rates(&mut ReferenceRenderer::new())?;
    match WgpuRenderer::new() {
        Ok(mut renderer) => rates(&mut renderer)?,
        Err(error @ RenderError::NoAdapter { .. }) => println!("wgpu: skipped, {error}"),
        Err(error) => return Err(error.into()),
    }
    Ok(())
}

fn rates(renderer: &mut dyn Renderer) -> Result<(), Box<dyn std::error::Error>> {
    let info = renderer.info();
    println!("{} on {} {}", info.renderer, info.adapter, info.driver);
    let scene = cluttered();
    let shot = look_at([1.3, -0.7, 0.8], [0.0, 0.0, 0.05]);
    let tile = |i: usize| TileShot {
        scene: &scene,
        shot,
        center: [100.0 + (i % 40) as f64 * 3.0, 90.0 + (i / 40 % 20) as f64 * 3.0],
        side: 70.0,
        target: 1 + (i % 5) as u32,
    };
    let tiles: Vec<_> = (0..TILES).map(tile).collect();
    renderer.frame(&scene, &shot)?;
    renderer.tiles(&tiles[..100], 32)?;
    measure("frames of 320x240", FRAMES, || {
        (0..FRAMES).try_for_each(|_| renderer.frame(&scene, &shot).map(drop))
    })?;
    measure("tiles of 32x32", TILES, || renderer.tiles(&tiles, 32).map(drop))
}

fn measure(
    what: &str,
    count: usize,
    work: impl FnOnce() -> Result<(), RenderError>,
) -> Result<(), Box<dyn std::error::Error>> {
    let (cpu, wall) = (cpu_seconds()?, Instant::now());
    work()?;
    let (cpu, wall) = (cpu_seconds()? - cpu, wall.elapsed().as_secs_f64());
    println!("  {what}: {:.0} per core-second, {:.0} per second", count as f64 / cpu, count as f64 / wall);
    Ok(())
}

/// User and system time of all threads of this process so far, to 10 ms (Linux only).
fn cpu_seconds() -> Result<f64, Box<dyn std::error::Error>> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let (_, after_name) = stat.rsplit_once(')').ok_or("no process name in /proc/self/stat")?;
    let ticks: Result<Vec<u64>, _> = after_name.split_whitespace().skip(11).take(2).map(str::parse).collect();
    Ok(ticks?.iter().sum::<u64>() as f64 / 100.0)
}
