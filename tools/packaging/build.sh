#!/usr/bin/env bash
# The Debian packages of mlr, in target/packaging:
#
#   apt-get install -y dpkg-dev python3
#   cargo install cargo-deb --version 3.8.0 --locked
#   tools/packaging/build.sh            # amd64 and arm64
#   tools/packaging/build.sh arm64
#
# amd64 is linked with the C library of this computer's Debian, or a later one; arm64 statically, for the
# Jetson Nano's Ubuntu 18.04 and everything after it, with the linker that comes with rustc. Every
# architecture is built on a computer of amd64.
set -euo pipefail
cd "$(dirname "$0")/../.."

architectures=("$@")
[ ${#architectures[@]} -gt 0 ] || architectures=(amd64 arm64)
host=x86_64-unknown-linux-gnu
out=target/packaging
files=$out/files

command -v cargo-deb >/dev/null || {
    echo "cargo-deb is needed: cargo install cargo-deb --version 3.8.0 --locked" >&2
    exit 2
}
[ "$(rustc -vV | sed -n 's/^host: //p')" = "$host" ] || {
    echo "this builds on $host only" >&2
    exit 2
}
sysroot=$(rustc --print sysroot)
objcopy=$sysroot/lib/rustlib/$host/bin/rust-objcopy

target_of() {
    case $1 in
        amd64) echo "$host" ;;
        arm64) echo aarch64-unknown-linux-musl ;;
        *)
            echo "no package for $1, expected amd64 or arm64" >&2
            exit 2
            ;;
    esac
}

# One after the other: together, the daemon would be compiled with the command line of mlr-ga. Always for
# a named target, so that the host's programs are found in the same way as all others.
build() {
    for package in mlrd mlr-ga; do
        cargo build --release --locked --target "$1" -p "$package"
    done
}

# Manual pages and completions come from the options of the programs, which are the same everywhere.
describe() {
    local programs=target/$host/release
    mkdir -p "$files/man" "$files/completions"
    "$programs/mlr-ga" man "$files/man" >/dev/null
    "$programs/mlrd" --generate man >"$files/man/mlrd.1"
    "$programs/mlrd" --generate man-check >"$files/man/mlrd-check.1"
    "$programs/mlrd" --generate man-top >"$files/man/mlrd-top.1"
    for shell in bash zsh fish; do
        case $shell in
            bash) names=(mlr-ga.bash mlrd.bash) ;;
            zsh) names=(_mlr-ga _mlrd) ;;
            fish) names=(mlr-ga.fish mlrd.fish) ;;
        esac
        "$programs/mlr-ga" completions "$shell" >"$files/completions/${names[0]}"
        "$programs/mlrd" --generate "complete-$shell" >"$files/completions/${names[1]}"
    done
}

version=$(cargo metadata --locked --no-deps --format-version 1 |
    python3 -c 'import json, sys; print(next(p["version"] for p in json.load(sys.stdin)["packages"] if p["name"] == "mlrd"))')
# The same commit makes the same package.
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH

build "$host"
for architecture in "${architectures[@]}"; do
    target=$(target_of "$architecture")
    [ "$target" = "$host" ] || build "$target"
    rm -rf "$files"
    mkdir -p "$files/bin" "$files/systemd"
    for program in mlrd mlr-ga; do
        LD_LIBRARY_PATH=$sysroot/lib "$objcopy" --strip-all "target/$target/release/$program" "$files/bin/$program"
    done
    describe
    # What is installed by hand is in /usr/local.
    sed 's|/usr/local/bin/|/usr/bin/|' crates/mlrd/systemd/mlrd.service >"$files/systemd/mlrd.service"
    python3 tools/packaging/third_party.py "$target" | gzip -9n >"$files/third-party.txt.gz"
    cat >"$files/changelog" <<CHANGELOG
mlr ($version-1) unstable; urgency=medium

  * Version $version: see CHANGELOG.md of the source.

 -- The mlr maintainers <maintainers@mlr.invalid>  $(date -uR -d "@$SOURCE_DATE_EPOCH")
CHANGELOG
    cargo deb -p mlrd --no-build --no-strip --locked --target "$target" \
        --output "$out/mlr_$version-1_$architecture.deb"
done
