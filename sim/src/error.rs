//! Why a simulation cannot be made.

use crate::mesh_file::MeshFileError;
use crate::render::RenderError;
use vantage_dataset::Split;

/// A world that does not stand, or a renderer that failed.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SimError {
    /// The objects find no room on the surface.
    #[error(
        "only {fitting} of {wanted} objects fit on the {surface}; use fewer objects, a smaller `world.spacing`, or a \
         larger surface"
    )]
    NothingFits {
        /// How many found room, the smallest first.
        fitting: usize,
        wanted: usize,
        surface: &'static str,
    },
    /// The scene has no family, and fewer meshes than it asks for.
    #[error(
        "`{field}` asks for {wanted}, but the scene has no family and only {got} meshes in the {} split, each of which is \
         one object; lower it, add to `world.meshes`, state their `split`, or list `world.families`",
        split.name()
    )]
    TooFewMeshes { field: &'static str, wanted: usize, got: usize, split: Split },
    /// An object kept moving.
    #[error(
        "object {object} ({family}) still moved {seconds:.0} s after it was dropped; another seed, a wider \
         `world.spacing` or other `world.families` may settle"
    )]
    DidNotSettle {
        object: usize,
        family: String,
        /// Simulated time it was given, seconds.
        seconds: f64,
    },
    /// An object's centre was no longer above its surface.
    #[error(
        "object {object} ({family}) left its surface and was at {position:.2?} m; another seed, a wider \
         `world.spacing` or a larger surface may hold it"
    )]
    LeftTheWorld {
        object: usize,
        family: String,
        /// Where it was, world frame, metres.
        position: [f64; 3],
    },
    /// The physics engine met a number that is not finite and took a body out of the world.
    #[error("the physics engine met a non-finite state of {body}; please report the scene and its seed")]
    NonFinite { body: String },
    /// The robot did not follow its path.
    #[error(
        "at step {step} the robot was {distance:.2} m from where its path has it; lower `robot.speed`, widen the \
         path's curves, or clear its way"
    )]
    LeftThePath {
        step: usize,
        /// Distance from where it should be, metres.
        distance: f64,
    },
    /// No walk was found that keeps clear of everything.
    #[error(
        "no random walk of {legs} legs keeps clear of everything, the longest found has {longest}; make `leg_length` or \
         `clearance` smaller, or clear the room"
    )]
    NoWalk { legs: usize, longest: usize },
    /// No loop was found that keeps clear of everything.
    #[error(
        "no random loop keeps {clearance} m clear of everything and turns no sharper than a circle of {sharpest} m; make \
         `clearance` or `amplitude` smaller, change `radius`, or clear the room"
    )]
    NoLoop {
        /// What was asked for, metres.
        clearance: f64,
        /// Least radius of a curve, metres.
        sharpest: f64,
    },
    /// Nowhere is a ring wide enough to be crossed.
    #[error(
        "nowhere can the robot cross the ring and drive round it {clearance} m clear of everything; make `clearance` smaller, \
         or leave a wider gap"
    )]
    NoCrossing {
        /// What was asked for, metres.
        clearance: f64,
    },
    /// The way between two passes cannot be as short as it should be.
    #[error("a detour of {detour} m is too short to come round; expected at least {least:.2} m")]
    NoDetour {
        /// What was asked for, metres.
        detour: f64,
        /// With so many metres, every seed has a way round.
        least: f64,
    },
    /// What stands in the room, or its wall, is in the way of a path that was drawn.
    #[error(
        "the path drawn for this seed passes at {gap:.2} m from a wall or an obstacle, at ({:.2}, {:.2}), expected at least \
         the robot's {} m; enlarge the room, clear the way, or take another seed",
        at[0], at[1], crate::plan::body::RADIUS
    )]
    BlockedPath {
        /// Where, world frame, metres.
        at: [f64; 2],
        /// Distance from the nearest wall or obstacle, metres; negative inside one.
        gap: f64,
    },
    /// No point of the grid is free.
    #[error(
        "no point of the grid is {clearance} m clear of everything; make `clearance` or `spacing` smaller"
    )]
    NoStation {
        /// What was asked for, metres.
        clearance: f64,
    },
    /// A path of stations is not driven.
    #[error("turntables and grids are no tracks to drive along; please report the scene")]
    NoTrack,
    /// The scene needs more memory than a simulation may take.
    #[error(
        "{what} would take about {} MB of memory, at most {} MB are allowed; reduce {remedy}",
        bytes / 1_000_000,
        limit / 1_000_000
    )]
    TooLarge {
        what: &'static str,
        /// The estimate, bytes.
        bytes: u64,
        /// The limit, bytes.
        limit: u64,
        field: &'static str,
        remedy: &'static str,
    },
    /// The scene plays longer than a simulation may.
    #[error(
        "the robot would drive for {seconds:.0} s, at most {limit:.0} s are simulated; raise `robot.speed`, or \
         shorten `robot.path` or `robot.laps`"
    )]
    TooLong {
        /// Simulated time, seconds.
        seconds: f64,
        /// The limit, seconds.
        limit: f64,
    },
    /// A mesh can no longer be used.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// The renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// How much of it is done.
    pub done: u64,
    /// How much of it there is.
    pub total: u64,
}

/// A stage of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Meshes are looked at, and prepared where they were not; counted in mesh files.
    Meshes,
    /// Furniture is read; counted in mesh files.
    Fixtures,
    /// Objects settle; counted in physics steps, of which fewer than the total may be needed.
    Settle,
    /// The robot drives; counted in steps of the episode.
    Drive,
    /// Images are rendered and objects detected; counted in steps of the episode.
    Observe,
    /// Training views are rendered; counted in instances.
    Views,
}
