#!/usr/bin/env bash
# Sets up what the tests need and runs them: the Rust tests and doc tests, then the Python witnesses, which recompute their reference
# values live and compare them with the committed ones. With --all, the SymPy proofs and the Python package too, which take minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

# A browser looks at the HTML report. Where there is none, that test says so and passes; not in continuous integration (CI is set),
# which installs one where it may, and fails without.
if ! command -v chromium chromium-browser google-chrome > /dev/null; then
    if [ -z "${CI:-}" ]; then
        echo "scripts/test.sh: no chromium: no browser will look at the HTML report (on Debian: apt install chromium)" >&2
    elif [ "$(id -u)" = 0 ] && command -v apt-get > /dev/null; then
        apt-get update -qq && apt-get install -qq -y --no-install-recommends chromium > /dev/null || {
            echo "scripts/test.sh: chromium could not be installed, and CI is set: a browser must look at the HTML report" >&2
            exit 1
        }
    else
        echo "scripts/test.sh: no chromium, and CI is set: a browser must look at the HTML report (on Debian: apt install chromium)" >&2
        exit 1
    fi
fi

# Compilers build the routines of docs/how-to/check-c-and-fortran.md; without them that page is not run.
# Valgrind watches what they do in the library's memory.
if ! command -v gfortran > /dev/null || ! command -v valgrind > /dev/null; then
    if [ -z "${CI:-}" ]; then
        echo "scripts/test.sh: no gfortran or no valgrind: their tests are left out (on Debian: apt install gfortran valgrind)" >&2
    elif [ "$(id -u)" = 0 ] && command -v apt-get > /dev/null; then
        apt-get update -qq && apt-get install -qq -y --no-install-recommends gcc gfortran valgrind > /dev/null
    fi
fi

if [ ! -x .venv/bin/pip ]; then
    python3 -m venv .venv || {
        echo "scripts/test.sh: python3 could not make a virtual environment (on Debian: apt install python3-venv)" >&2
        exit 1
    }
fi
if ! cmp -s scripts/requirements.txt .venv/installed.txt; then
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --requirement scripts/requirements.txt
    cp scripts/requirements.txt .venv/installed.txt
fi

# After the environment: the tests run exported Python programs in it.
cargo test --workspace --all-features --no-run
# What is built is not built again: witnesses and proofs ask this program.
built=$(cd "${CARGO_TARGET_DIR:-target}/debug" && pwd)
export PINTLE_PROGRAM="$built/pintle" PINTLE_PEER_RULES="$built/examples/peer_rules"

# What takes minutes of one core runs beside the rest, and tells at the end what it found.
logs=$(mktemp -d)
trap 'kill $(jobs -p) 2> /dev/null || true; rm -rf "$logs"' EXIT
ended() {
    echo "$2"
    wait "$1" || {
        cat "$logs/$3"
        exit 1
    }
    cat "$logs/$3"
}

proofs=scripts/proof/prove.py
if [ "${1:-}" = --all ]; then
    nice -n 10 .venv/bin/python "$proofs" --check > "$logs/proofs" 2>&1 &
    proving=$!
fi

cargo test --workspace --all-features

# The package of Python, of what the tests have built.
if [ "${1:-}" = --all ]; then
    PATH="$PWD/.venv/bin:$PATH" .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation \
        --force-reinstall --config-settings=build-args="--profile dev --features tests" ./python
    .venv/bin/python -m pytest --quiet python/tests > "$logs/package" 2>&1 &
    testing=$!
fi

passed=0
for witness in $(grep --files-with-matches -- '"--check"' scripts/*.py scripts/*/*.py); do
    [ "$witness" = "$proofs" ] && continue
    echo "$witness --check"
    .venv/bin/python "$witness" --check
    passed=$((passed + 1))
done
if [ "$passed" = 0 ]; then
    echo "scripts/test.sh: no script takes --check: nothing witnesses the reference values" >&2
    exit 1
fi
if [ "${1:-}" = --all ]; then
    ended "$testing" "pytest python/tests" package
    ended "$proving" "$proofs --check" proofs
    passed=$((passed + 1))
fi
echo "witnesses: $passed passed, 0 failed"
