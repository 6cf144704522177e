#!/bin/sh
# Rates of our renderers beside MuJoCo's and PyBullet's, on the same scene, as a Markdown table.
#
#   sim/benches/peers.sh [FOLDER [ROUNDS [MODELS [TRIANGLES]]]]
#
# FOLDER (out/peers) takes a virtual environment and the exported scene. Needs Python 3 with venv, a Vulkan driver for wgpu and
# EGL (libegl1, libgl1-mesa-dri) for MuJoCo. MODELS is a folder of YCB models (from the repository's root) that stand on the table in place of
# our objects, simplified to so many TRIANGLES at most. On a machine with a GPU compare nothing: rates are per second of the CPU.
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-out/peers}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet mujoco==4.0.0 pybullet==3.2.7 numpy pillow
cargo build --release --locked --quiet -p vantage-sim --example render_rate
rate="${CARGO_TARGET_DIR:-target}/release/examples/render_rate"
rounds=${2:-5}
set -- ${3:+--models} ${3:+"$3"} ${4:+"$4"}
"$rate" export "$folder/scene" "$@"
exec "$folder/venv/bin/python" sim/benches/peers.py compare "$folder/scene" "$rounds" "$rate" "$@"
