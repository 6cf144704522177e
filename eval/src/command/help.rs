//! What `bench --help` says below the options.

/// Examples, below the short help and the long one.
pub const EXAMPLES: &str = "\
Examples:
  bench list                                 scenes, models, studies and maps that come with it
  bench tabletop                             runs a scene, with all of its seeds
  bench tabletop --seeds 2                   the same sooner, with too few seeds to show a gain
  bench my_scene.yaml --model out/my_model   a scene and a model of your own
  bench tabletop --trajectories out/mine     another estimator's trajectories beside ours
  bench look tabletop                        draws a scene
  bench dataset tabletop --out out/data      writes crops, detections, odometry and truth

`bench help COMMAND` tells what a command takes, `bench --help` the exit codes.";

/// Exit codes and where to read on, between the long help and the examples.
pub const EXIT_CODES: &str = "\
Exit codes:
    0  all was done; of `check`, nothing moved
    2  a scene, argument or baseline that cannot be used
    3  the machine or this build lacks something, such as a Vulkan driver
    4  nothing was evaluated
    5  stored data (cache, model, results) is not what was written
    6  the output or the cache cannot be written
   10  of `check`: a score moved out of its tolerance
   70  a bug in bench
  130  interrupted by Ctrl-C

Documentation: README.md and docs/ of the repository; `bench schema` describes scene files.";
