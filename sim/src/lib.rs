//! The simulator: the generative side of the posterior of Eq. 1, from a checked scene to episodes and views.
//!
//! ```text
//! x_k+1 = f(x_k, u_k)                              pure pursuit, one step of rigid bodies in 1/120 s
//! u_k   = x_k^-1 x_k+1 Exp(s(u) * n_k + d(u) * b)  odometry (Eq. 3): n_k anew at each step, b once an episode
//! p     = (fx X/Z + cx, fy Y/Z + cy)               a point (X, Y, Z) of the camera's frame, pixels
//! I(p)  = a (l_a + l_d max(0, n . l))              nearest surface: albedo a, normal n, light l; linear RGB
//! z^g   = box and area of the visible mask         Eq. 6
//! z^s   = crop of 32 x 32 x 3 around the box       Eq. 9-10
//! ```
//!
//! | of the model | module |
//! |---|---|
//! | what a scene file says, and the rules of each part | [`scene`] |
//! | the floor: what stands where, and curves to drive along | [`plan`] |
//! | surfaces, textures and levels of detail | [`mesh`], [`texture`], [`model`] |
//! | p, I: images with depth and ids | [`render`] |
//! | o: meshes from files, and procedural objects | [`mesh_file`], [`object`] |
//! | f: rigid bodies | [`physics`] |
//! | rules between the parts of a scene, and what it may cost | [`checked`], [`budget`] |
//! | x: the world at rest, and the robot's way through it | [`world`], [`robot`] |
//! | u, z^g, z^s, point landmarks, and their faults | [`sensor`] |
//! | an episode, step by step | [`rollout`], [`observer`], [`mod@episode`], [`mod@capture`] |
//! | views of single objects, z^s with their x_rel | [`views`] |
//!
//! A module uses those above it in the table and none below. The world is z-up, cameras are OpenCV's, lengths are metres.
//! Every noise has a random stream of its own, named after what it decides.

pub mod budget;
pub mod capture;
pub mod checked;
pub mod convert;
pub mod episode;
pub mod error;
pub mod mesh;
pub mod mesh_file;
pub mod model;
pub mod object;
pub mod observer;
pub mod physics;
pub mod plan;
pub mod render;
pub mod robot;
pub mod rollout;
pub mod scene;
pub mod sensor;
pub mod texture;
pub mod views;
pub mod world;

pub use episode::simulate;
