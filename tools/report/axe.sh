#!/usr/bin/env bash
# Checks a report with axe-core, the accessibility checker.
#   tools/report/axe.sh report.html
# needs chromium, npm and python3; downloads axe-core.
set -euo pipefail
page=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
npm install --silent --no-fund --no-audit --prefix "$folder" axe-core@4
cp "$page" "$folder/page.html"
# The page allows no scripts: axe runs in a copy that does.
sed -i 's|<meta http-equiv="Content-Security-Policy"[^>]*>||' "$folder/page.html"
cat >>"$folder/page.html" <<'HTML'
<script src="node_modules/axe-core/axe.min.js"></script>
<script>
axe.run(document, { resultTypes: ["violations"] }).then((found) => {
  const told = document.createElement("pre");
  told.id = "axe";
  told.textContent = JSON.stringify({
    passes: found.passes.length,
    incomplete: found.incomplete.map((one) => [one.id, one.nodes.length]),
    violations: found.violations.map((one) => [one.id, one.impact, one.nodes.map((node) => node.target.join(" "))]),
  });
  document.body.append(told);
});
</script>
HTML
for scheme in 1 0; do
    chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --dump-dom \
        --user-data-dir="$folder/chromium" --virtual-time-budget=30000 \
        --blink-settings=preferredColorScheme="$scheme" "file://$folder/page.html" 2>/dev/null |
        python3 -c '
import html, json, re, sys
found = json.loads(html.unescape(re.search("<pre id=\"axe\">(.*?)</pre>", sys.stdin.read(), re.S).group(1)))
print(found["passes"], "rules passed; undecided:", found["incomplete"])
for rule, impact, places in found["violations"]:
    print(impact, rule, *places, sep="\n  ")
sys.exit(bool(found["violations"]))'
done
