#!/usr/bin/env bash
# Makes third_party/rapier3d of the released crate and the patches beside this script; with --check, compares only.
set -euo pipefail
cd "$(dirname "$0")"

version=0.36.1
sha256=033e2edc815d61ab97bd74ed5d1cbea5ebe575218774a7cfedbd3551f0033317

made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
curl --fail --silent --show-error --location -o "$made/crate" \
    "https://static.crates.io/crates/rapier3d/rapier3d-$version.crate"
echo "$sha256  $made/crate" | sha256sum --check --quiet
tar -xzf "$made/crate" -C "$made"
crate=$made/rapier3d-$version
# What a dependency is not built from: tests and examples, and what the manifest says of them.
rm -r "$crate"/{tests,examples,Cargo.lock,Cargo.toml.orig,.cargo_vcs_info.json}
awk '/^\[/ { kept = !/^\[\[|^\[dev-dependencies/ } kept' "$made/rapier3d-$version/Cargo.toml" > "$made/manifest"
mv "$made/manifest" "$crate/Cargo.toml"
for change in sparse-mass-matrix isotropic-friction; do
    patch --quiet --directory "$crate" --strip 1 < "rapier3d-$change.patch"
done
cp ../LICENSE-APACHE "$crate/LICENSE"

if [ "${1:-}" = --check ]; then
    diff --recursive "$crate" rapier3d
    echo "third_party/rapier3d is rapier3d $version with the patches"
else
    rm -rf rapier3d
    mv "$crate" rapier3d
fi
