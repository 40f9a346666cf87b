#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The test command: installs what is missing, builds, runs every test, and ends with counts.
#   OPENNTC_SHARED_DIR=DIR  folder with LibNTC's vectors (default ../shared; its tests skip when it is absent)
#   OPENNTC_STAGES="release asan clang mingw aarch64 format tidy"  stages to run
#   OPENNTC_TIDY=all        tidy every file, without the time limit
# Logs are in build/logs. Exit status 0 only if nothing failed and the vectors V1 and V2 ran.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

stages=" ${OPENNTC_STAGES:-release asan clang mingw aarch64 format tidy} "
jobs="$(nproc)"
logs="build/logs"
mkdir -p "$logs"
rm -f "$logs"/*.log
passed=0
failed=0
skipped=0
failures=()
started=$SECONDS

export CTEST_PARALLEL_LEVEL="$jobs"
export UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1${UBSAN_OPTIONS:+:$UBSAN_OPTIONS}"
# Leaks of the Vulkan driver and loader are not ours.
export LSAN_OPTIONS="suppressions=$PWD/tests/support/leaks.supp:print_suppressions=0${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
shared=()
if [[ -n "${OPENNTC_SHARED_DIR:-}" ]]; then
    shared=("-DOPENNTC_SHARED_DIR=$OPENNTC_SHARED_DIR")
fi

want() { [[ "$stages" == *" $1 "* ]]; }

# step NAME COMMAND…: runs it into a log; counts one pass or one failure and shows the log's end on failure.
step() {
    local name="$1" log="$logs/$1.log" begin=$SECONDS
    shift
    if "$@" >"$log" 2>&1 </dev/null; then
        passed=$((passed + 1))
        echo "ok    $name ($((SECONDS - begin)) s)"
    else
        failed=$((failed + 1))
        failures+=("$name")
        echo "FAIL  $name ($((SECONDS - begin)) s); the end of $log:"
        grep -E 'error|FAILED|warning:' "$log" | head -20
        tail -n 40 "$log"
        return 1
    fi
}

# Counts the tests of one CTest log: doctest's cases where it prints them, one otherwise; each "SKIP: reason" is a
# skipped test, and not a passed one.
count_tests() {
    awk '
        /^[0-9]+\/[0-9]+ Testing: / { good = 0; bad = 0; skip = 0; cases = 0 }
        /^Command: / { next }
        /^\[doctest\] test cases:/ {
            line = $0; sub(/.*test cases:/, "", line); split(line, part, "|")
            good += part[2] + 0; bad += part[3] + 0; cases = 1
        }
        /SKIP: / { skip++ }
        /^Test Passed\.$/ { if (!cases) good = 1; Done() }
        /^Test Failed\.$|^\*\*\*/ { if (bad == 0) bad = 1; Done() }
        function Done() { good -= skip; if (good < 0) good = 0; P += good; F += bad; K += skip; good = bad = skip = 0 }
        END { print P + 0, F + 0, K + 0 }' "$1"
}

# build_and_test PRESET [LABEL]: everything, or the tests of one label.
build_and_test() {
    local preset="$1" log="build/$1/Testing/Temporary/LastTest.log" begin p f k ok=1
    local build=() tests=()
    if [[ $# -gt 1 ]]; then
        build=(--target "tests_$2")
        tests=(-L "^$2\$")
    fi
    step "$preset-configure" cmake --preset "$preset" "${launcher[@]}" "${shared[@]}" || return
    step "$preset-build" cmake --build --preset "$preset" --parallel "$jobs" "${build[@]}" || return
    rm -f "$log"
    begin=$SECONDS
    if ctest --preset "$preset" "${tests[@]}" >"$logs/$preset-tests.log" 2>&1 </dev/null; then
        echo "ok    $preset tests ($((SECONDS - begin)) s)"
    else
        echo "FAIL  $preset tests ($((SECONDS - begin)) s); the end of $logs/$preset-tests.log:"
        grep -E 'ERROR|FATAL|\*\*\*' "$logs/$preset-tests.log" | head -40
        tail -n 60 "$logs/$preset-tests.log"
        failures+=("$preset-tests")
        ok=0
    fi
    p=0 f=0 k=0
    if [[ -f "$log" ]]; then
        cp "$log" "$logs/$preset-output.log"
        read -r p f k < <(count_tests "$log")
    fi
    if [[ "$ok" -eq 0 && "$f" -eq 0 ]]; then
        f=1 # for example a test that could not be started
    fi
    passed=$((passed + p))
    failed=$((failed + f))
    skipped=$((skipped + k))
    grep -avE '^Command: ' "$log" | grep -aoE 'SKIP: .*' | sort | uniq -c | sed "s/^/      $preset: /"
}

sources() {
    if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
        git ls-files --cached --others --exclude-standard -- "$@"
    else
        find include shaders tests examples -type f \( -name '*.h' -o -name '*.cpp' \)
    fi
}

check_format() {
    sources '*.h' '*.cpp' '*.inl' | xargs -r -d '\n' clang-format --dry-run -Werror
}

# Files that differ from the last landed commit: the branch point from origin, or else the parent commit.
changed_sources() {
    local base
    if [[ "${OPENNTC_TIDY:-}" == all ]]; then
        sources 'include/*.h' 'shaders/*.h' 'examples/*.h' '*.cpp'
        return
    fi
    base="$(git merge-base HEAD origin/main 2>/dev/null || true)"
    if [[ -z "$base" || "$base" == "$(git rev-parse HEAD 2>/dev/null)" ]]; then
        base="$(git rev-parse HEAD~1 2>/dev/null || git hash-object -t tree /dev/null)"
    fi
    git diff --name-only --diff-filter=d "$base" -- '*.h' '*.cpp'
}

# The release preset compiles several sources as one (unity builds); clang-tidy wants a command for each of them.
write_tidy_commands() {
    mkdir -p "$logs/tidy"
    awk '
        BEGIN { print "["; separator = "" }
        /^ *"directory":/ { directory = $0 }
        /^ *"command":/ { command = $0 }
        /^ *"file":/ {
            split($0, part, "\"")
            file = part[4]
            if (file !~ /\/unity_[0-9]+_cxx\.cxx$/) {
                Write(file)
            } else {
                while ((getline line <file) > 0) {
                    if (split(line, part, "\"") > 2) Write(part[2])
                }
            }
        }
        function Write(source) {
            own = command
            sub(/ -c [^ ]*",$/, " -c " source "\",", own)
            printf "%s{\n%s\n%s\n  \"file\": \"%s\"\n}", separator, directory, own, source
            separator = ",\n"
        }
        END { print "\n]" }' build/release/compile_commands.json >"$logs/tidy/compile_commands.json"
}

tidy_file() {
    if [[ "$SECONDS" -ge "$TIDY_DEADLINE" ]]; then
        echo "not reached in time: $1"
        return 0
    fi
    local report
    report="$(clang-tidy --quiet -p build/logs/tidy --extra-arg=-Wno-unknown-warning-option "$1" 2>&1)" && return 0
    echo "$report"
    return 1
}

# The changed public headers are checked through one source that includes them.
tidy_headers() {
    local source="$logs/tidy_headers.cpp"
    changed_sources | sed -nE 's,^(include|shaders)/(openntc/.*\.h)$,#include "\2",p' >"$source"
    [[ ! -s "$source" ]] || clang-tidy --quiet "$source" -- -std=c++20 -Iinclude -Ishaders
}

check_tidy() {
    export -f tidy_file
    local limit=120 status=0
    if [[ "${OPENNTC_TIDY:-}" == all ]]; then
        limit=36000
    fi
    # Every tidy_file runs in a shell of its own, whose SECONDS starts from what it is given here.
    export TIDY_DEADLINE=$(($(date +%s) + limit))
    write_tidy_commands
    tidy_headers || status=1
    changed_sources | sed -n '/\.cpp$/p' |
        xargs -r -d '\n' -P "$jobs" -n 1 bash -c 'SECONDS=$(date +%s); tidy_file "$1"' tidy || status=1
    return "$status"
}

step install bash tests/install.sh || exit 1
if want release; then build_and_test release; fi
if want asan; then build_and_test asan; fi
if want clang; then build_and_test clang unit; fi
if want mingw; then build_and_test mingw unit; fi
if want aarch64; then build_and_test aarch64 unit; fi
if want format; then step format check_format; fi
if want tidy; then
    step tidy check_tidy
    grep -c 'not reached in time' "$logs/tidy.log" | sed 's/^/      tidy: files not reached in time: /'
fi

echo
awk '
    /VECTORS ran=/ {
        match($0, /ran=[0-9]+/); ran = substr($0, RSTART + 4, RLENGTH - 4)
        match($0, /skipped=[0-9]+/); skip = substr($0, RSTART + 8, RLENGTH - 8)
        match($0, /name=[^ ]+/); name = substr($0, RSTART + 5, RLENGTH - 5)
        R[name] += ran; S[name] += skip; r += ran; s += skip
    }
    END {
        for (name in R) printf "vectors %s: %d run, %d skipped\n", name, R[name], S[name] | "sort"
        close("sort")
        printf "conformance vectors: %d run, %d skipped\n", r, s
    }' "$logs"/*-output.log 2>/dev/null
for vector in V1 V2; do
    if ! grep -aqE "VECTORS ran=[1-9][0-9]* .*name=$vector( |\$)" "$logs"/*-output.log 2>/dev/null; then
        echo "FAIL  vectors $vector did not run"
        failed=$((failed + 1))
        failures+=("vectors-$vector")
    fi
done
echo "time: $((SECONDS - started)) s"
if [[ ${#failures[@]} -gt 0 ]]; then
    echo "failed: ${failures[*]}"
fi
echo "$passed passed, $failed failed, $skipped skipped"
[[ "$failed" -eq 0 ]]
