#!/bin/sh
# Rates of our renderers beside MuJoCo's and PyBullet's, on the same scene, as a Markdown table.
#
#   sim/benches/peers.sh [FOLDER [ROUNDS]]
#
# FOLDER (out/peers) takes a virtual environment and the exported scene. Needs Python 3 with venv, a Vulkan driver for wgpu and
# EGL (libegl1, libgl1-mesa-dri) for MuJoCo; on a machine with a GPU compare nothing: rates are per second of the CPU.
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-out/peers}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet mujoco==4.0.0 pybullet==3.2.7 numpy pillow
cargo build --release --locked --quiet -p vantage-sim --example render_rate
rate="${CARGO_TARGET_DIR:-target}/release/examples/render_rate"
"$rate" export "$folder/scene"
exec "$folder/venv/bin/python" sim/benches/peers.py compare "$folder/scene" "$rate" "${2:-5}"
