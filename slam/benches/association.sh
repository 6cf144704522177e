#!/bin/sh
# Association on cases of others, and beside GTSAM's HybridSmoother and DCSAM in the same shuffled order.
#
#   slam/benches/association.sh [CASES [FOLDER [SEED]]]
#
# CASES (shared/data/association) is a folder with the files of MH-iSAM2 and of Mu et al. FOLDER (out/association) takes a virtual environment and
# shuffled files, 300 MB. Needs Linux and Python 3.11 with venv. Times are of the processor. HybridSmoother takes minutes.
set -eu
cd "$(dirname "$0")/../.."
cases=${1:-${VANTAGE_SHARED:-shared}/data/association}
folder=${2:-out/association}
seed=${3:-1}
mkdir -p "$folder"
[ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet gtsam==4.3.0 numpy
cargo build --release --locked --quiet -p vantage-slam --example association
ours="${CARGO_TARGET_DIR:-target}/release/examples/association"
peer="$folder/venv/bin/python slam/benches/association.py"
victoria=$cases/mh_T2_victoriaPark_01.txt
city=$cases/mh_T1_city10000_04.txt
truth=$cases/ISAM2_GT_city10000.txt

echo "## Victoria Park"
"$ours" victoria "$victoria" "$seed"
echo "## Victoria Park, HybridSmoother"
"$ours" shuffled "$victoria" "$seed" 1000000 > "$folder/victoria.txt"
$peer smoother victoria "$folder/victoria.txt"
echo "## Victoria Park, 1000 lines, HybridSmoother and DCSAM"
"$ours" shuffled "$victoria" "$seed" 1000 > "$folder/victoria_1000.txt"
$peer smoother victoria "$folder/victoria_1000.txt"
$peer alternation victoria "$folder/victoria_1000.txt"
echo "## City10000, 500 lines"
"$ours" city "$city" "$truth" "$seed" 500
echo "## City10000, 500 lines, HybridSmoother and DCSAM"
"$ours" shuffled "$city" "$seed" 500 > "$folder/city.txt"
$peer smoother city "$folder/city.txt"
$peer alternation city "$folder/city.txt"
echo "## City10000"
"$ours" city "$city" "$truth" "$seed"
echo "## City10000, loops that may be false"
"$ours" detachable "$cases/mh_T3b_city10000_10.txt" "$truth" "$seed"
echo "## Objects of Mu et al."
"$ours" mu "$cases/mu2016_simulation.mat" 5
echo "## Generated worlds that no setting was chosen on"
"$ours" generated 3000 40
