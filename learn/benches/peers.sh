#!/bin/sh
# Speed of training beside PyTorch's, and of tract beside onnxruntime's, on the same networks, as Markdown tables.
#
#   learn/benches/peers.sh [FOLDER [ROUNDS]]
#
# FOLDER (out/peers-learn) takes a virtual environment and graphs for batches. Needs Python 3 with venv, and a quiet machine: PyTorch's threads spin while
# they wait, so that another program costs them far more than ours.
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-out/peers-learn}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet torch==2.15.0 onnxruntime==1.31.1 onnx==1.23.2 numpy
cargo build --release --locked --quiet -p vantage-learn --example speed
speed="${CARGO_TARGET_DIR:-target}/release/examples/speed"
exec "$folder/venv/bin/python" learn/benches/peers.py compare "$speed" models/objects "$folder/batched" "${2:-5}"
