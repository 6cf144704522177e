#!/bin/sh
# What `bench` writes, read by the programs that it is written for: evo, GTSAM, pycocotools, h5py, SciPy, datasets and
# webdataset.
#
#   tests/peers/check.sh [FOLDER]
#
# FOLDER (out/peers-check) takes a virtual environment and the data. Needs Python 3 with venv, and a network the first time; builds the program.
# Ends with 0 if all agree.
set -eu
cd "$(dirname "$0")/../.."
folder=${1:-out/peers-check}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet evo==1.38.1 gtsam==4.3.0 pycocotools==2.0.11 h5py==3.16.0 scipy==1.17.1 \
    datasets==5.2.0 webdataset==1.0.2 pillow==13.0.0 numpy==2.4.6
cargo build --release --locked --quiet -p vantage-eval --bin bench
exec "$folder/venv/bin/python" tests/peers/check.py "${CARGO_TARGET_DIR:-target}/release/bench" "$folder/data"
