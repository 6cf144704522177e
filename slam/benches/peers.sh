#!/bin/sh
# Our back-end beside GTSAM's, on the same graphs, as Markdown tables: step by step, at once, and marginals.
#
#   slam/benches/peers.sh [FOLDER [ROUNDS [POSE_GRAPHS]]]
#
# FOLDER (out/peers-slam) takes a virtual environment and the graphs, 300 MB. POSE_GRAPHS (shared/data/g2o) is a folder of graphs in the g2o
# format. Needs Linux, Python 3.11 with venv, and 10 GB of memory, which iSAM2 takes. Times are of the processor.
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-out/peers-slam}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet gtsam==4.3.0 numpy
cargo build --release --locked --quiet -p vantage-slam --example peers
peers="${CARGO_TARGET_DIR:-target}/release/examples/peers"
graphs=${3:-${VANTAGE_SHARED:-shared}/data/g2o}
exec "$folder/venv/bin/python" slam/benches/peers.py compare "$peers" "$graphs" "$folder" "${2:-5}"
