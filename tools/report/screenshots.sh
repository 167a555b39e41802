#!/usr/bin/env bash
# Screenshots of a report: at the width of a desktop and of a phone, light and dark.
#   tools/report/screenshots.sh report.html FOLDER
# needs chromium.
set -euo pipefail
page=$(realpath "$1")
folder=$2
mkdir -p "$folder"
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT

# A window of a phone cannot be narrower than 500 pixels, a frame can.
shot() {
    local width=$1 height=$2 name=$3 scheme=$4
    local frame="$profile/frame.html"
    printf '<!DOCTYPE html><body style="margin:0"><iframe src="file://%s" style="border:0;width:%spx;height:%spx">' \
        "$page" "$width" "$height" >"$frame"
    chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --disable-dev-shm-usage \
        --user-data-dir="$profile/chromium" --blink-settings=preferredColorScheme="$scheme" \
        --window-size="$width,$height" --screenshot="$folder/$name.png" "$frame" 2>/dev/null
}

height=${HEIGHT:-2600}
shot 1280 "$height" desktop-light 1
shot 1280 "$height" desktop-dark 0
shot 390 "$((2 * height))" phone-light 1
shot 390 "$((2 * height))" phone-dark 0
