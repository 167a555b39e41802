#!/usr/bin/env bash
# Builds the wheel of the Python package, installs it in a fresh virtual environment, and tests it there:
# pytest against the command line, mypy on the types, and the example.
#
#     tools/python/test.sh [ARGUMENTS OF PYTEST]
#
# PYTHON names the interpreter (python3), PROFILE the profile of both builds (dev).
set -euo pipefail
cd "$(dirname "$0")/../.."

python=${PYTHON:-python3}
profile=${PROFILE:-dev}
package=crates/mlr-py
work=$PWD/target/python
venv=$work/venv

"$python" tools/python/answers.py --check

rm -rf "$venv" "$work/wheels"
"$python" -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --requirement tools/python/requirements.txt

# Both share what is compiled of the dependencies.
cargo build --locked --profile "$profile" -p mlr-ga --bin mlr-ga
"$venv/bin/maturin" build --quiet --locked --profile "$profile" --compatibility linux \
    --manifest-path "$package/Cargo.toml" --out "$work/wheels"
"$venv/bin/pip" install --quiet --disable-pip-version-check "$work"/wheels/*.whl

folder=$profile
[ "$profile" = dev ] && folder=debug
export MLR_GA=${CARGO_TARGET_DIR:-$PWD/target}/$folder/mlr-ga MLR_DATA=$PWD/data

"$venv/bin/mypy" --config-file "$package/pyproject.toml" --package mlr
"$venv/bin/mypy" --config-file "$package/pyproject.toml" "$package/tests" "$package/examples"
MPLBACKEND=agg "$venv/bin/python" "$package/examples/damaged_walk.py" "$work/damaged_walk.png"
# From another folder, so that what is tested is the wheel.
cd "$work"
"$venv/bin/pytest" --rootdir "$OLDPWD/$package" "$OLDPWD/$package/tests" "$@"
