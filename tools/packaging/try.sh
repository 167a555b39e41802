#!/usr/bin/env bash
# Installs a package of tools/packaging/build.sh in a Debian of its own, upgrades it with settings that
# were changed, removes it and purges it, and looks after each step. Runs as root:
#
#   apt-get install -y debootstrap
#   tools/packaging/try.sh target/packaging/mlr_0.1.0-1_amd64.deb [DEBIAN_MIRROR]
set -euo pipefail
cd "$(dirname "$0")/../.."

package=$1
mirror=${2:-http://deb.debian.org/debian}
work=$(mktemp -d)
root=$work/debian
trap 'rm -rf "$work"' EXIT

step() { printf '\n== %s\n' "$*"; }
ok() { printf 'ok  %s\n' "$*"; }
fail() {
    printf 'FAILED  %s\n' "$*" >&2
    exit 1
}
expect() { # what, command…
    local what=$1
    shift
    if "$@" >"$work/said" 2>&1; then
        ok "$what"
    else
        cat "$work/said" >&2
        fail "$what"
    fi
}
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
has() { [ -e "$root$1" ]; }
lacks() { ! has "$1"; }
says() { # text, command…
    local text=$1
    shift
    # Into a file: grep would close the pipe before the program has said all.
    "$@" >"$work/output" 2>&1 && grep -qF -- "$text" "$work/output" || {
        cat "$work/output"
        return 1
    }
}

step "a Debian of its own"
debootstrap --variant=minbase --include=adduser,man-db,systemd bookworm "$root" "$mirror" >"$work/debootstrap.log" 2>&1 ||
    { tail "$work/debootstrap.log" >&2; fail "debootstrap"; }
ok "debootstrap: Debian $(cat "$root/etc/debian_version")"
# Its minimal image leaves out manual pages; ours are looked at.
rm -f "$root"/etc/dpkg/dpkg.cfg.d/*
cp "$package" "$root/mlr.deb"
version=$(dpkg-deb -f "$package" Version)

# A later version of the package, with the same settings or with others.
later() { # name, suffix, line to append to the settings
    local tree=$work/$1
    dpkg-deb -R "$package" "$tree"
    sed -i "s/^Version: .*/Version: $version+$2/" "$tree/DEBIAN/control"
    [ -z "$3" ] || echo "$3" >>"$tree/etc/mlrd.toml"
    (cd "$tree" && find etc usr -type f -print0 | sort -z | xargs -0 md5sum >DEBIAN/md5sums)
    dpkg-deb --root-owner-group -Zgzip -b "$tree" "$root/$1.deb" >/dev/null
}
later same-settings 1 ""
later other-settings 2 "# a new setting"

step "install"
inside dpkg -i /mlr.deb </dev/null >"$work/install.log" 2>&1 || { cat "$work/install.log"; fail "dpkg -i"; }
ok "dpkg -i"
expect "the note says how to start and how to build an atlas" grep -q 'mlr-ga atlas build' "$work/install.log"
expect "dpkg --audit finds nothing" test -z "$(inside dpkg --audit)"
expect "files are as packaged" inside dpkg --verify mlr
expect "mlrd runs" says "mlrd ${version%-*}" inside mlrd --version
expect "mlr-ga runs" says "mlr-ga ${version%-*}" inside mlr-ga --version
expect "the shipped settings are valid" says 'port = "/dev/ttyTHS1"' inside mlrd --config /etc/mlrd.toml --print-config
expect "the group of the I2C bus is there" inside getent group i2c
expect "the unit starts the installed program" grep -q '^ExecStart=/usr/bin/mlrd ' "$root/usr/lib/systemd/system/mlrd.service"
expect "systemd understands the unit" inside systemd-analyze verify --man=no /usr/lib/systemd/system/mlrd.service
for page in mlrd mlrd-top mlrd-check mlr-ga mlr-ga-identify; do
    expect "man $page" says SYNOPSIS inside man "$page"
done
expect "completions for bash" bash -n "$root/usr/share/bash-completion/completions/mlrd"
expect "licences of the crates inside" says "rapier3d" zcat "$root/usr/share/doc/mlr/third-party.txt.gz"
expect "mlr-ga makes a log" inside mlr-ga simulate --legs-lost 3 -o /walk.csv
expect "mlr-ga finds the damage in it" says '"damage_s"' inside mlr-ga detect /walk.csv --json
{
    echo "t_s,roll_rad,pitch_rad,yaw_rad"
    for index in $(seq 0 300); do echo "$((index / 100)).$(printf %02d $((index % 100))),0.000$((index % 7)),0.0,0.0"; done
} >"$root/samples.csv"
expect "mlrd watches a sensor and top shows it" says "stopped" inside sh -c \
    'mlrd --stdin --state-dir /var/lib/mlrd < /samples.csv | mlrd top'

step "upgrade with changed settings"
echo "# my own" >>"$root/etc/mlrd.toml"
sed -i 's|^port = .*|port = "/dev/ttyUSB7"|' "$root/etc/mlrd.toml"
cp "$root/etc/mlrd.toml" "$work/mine.toml"
touch "$root/var/lib/mlrd/calibration.json"
mine() { cmp "$work/mine.toml" "$root/etc/mlrd.toml"; }
expect "to a version with the same settings, no question asked" inside sh -c 'dpkg -i /same-settings.deb </dev/null'
expect "the settings are the changed ones" mine
expect "the version is the later one" says "$version+1" inside dpkg-query -W -f '${Version}' mlr
expect "to a version with other settings" inside sh -c 'dpkg -i --force-confdef --force-confold /other-settings.deb </dev/null'
expect "the settings are the changed ones" mine
expect "the new ones lie beside them" grep -q '# a new setting' "$root/etc/mlrd.toml.dpkg-dist"
expect "mlrd reads them" says '/dev/ttyUSB7' inside mlrd --config /etc/mlrd.toml --print-config
expect "what was learned is there" has /var/lib/mlrd/calibration.json

step "remove"
expect "dpkg -r" inside dpkg -r mlr
expect "the programs are gone" lacks /usr/bin/mlrd
expect "the settings stay" mine
expect "what was learned stays" has /var/lib/mlrd/calibration.json

step "install again, and purge"
expect "dpkg -i" inside sh -c 'dpkg -i --force-confdef --force-confold /mlr.deb </dev/null'
expect "the settings are still the changed ones" mine
expect "dpkg -P" inside dpkg -P mlr
left=$(find "$root" -xdev \( -name '*mlr*' -o -path '*/var/lib/private/*' \) -not -path "$root/proc/*" \
    -not -path "$root/mlr.deb" -not -path "$root/var/log/*" -not -path "$root/var/cache/*")
[ -z "$left" ] || fail "left behind: $left"
ok "nothing is left"
expect "dpkg does not know it" sh -c "! chroot '$root' dpkg -s mlr"
printf '\nall steps passed: %s\n' "$package"
