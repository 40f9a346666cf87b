#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The test command: installs what is missing, builds, runs every test, and ends with counts and the time of every stage.
#   OPENNTC_SHARED_DIR=DIR  folder with LibNTC's vectors (default ../shared; its tests skip when it is absent)
#   OPENNTC_STAGES="release slurm caps compilers web asan clang plain tsan libcxx mingw aarch64 format tidy"  stages to run
#   OPENNTC_STAGES=all      every stage, `coverage` too, in full
#   OPENNTC_STAGES="release compilers-all"  every shader compiler with every network and maths mode
#   OPENNTC_BASE=REVISION   what "changed" is measured from (see landed_base)
#   OPENNTC_TIDY=all        tidy every file, without the time limit; =changed: the changed ones, without the limit
# Stage release builds everything with g++ and runs every test; slurm and caps run its programs, compilers hands its shaders to
# compilers other than glslang, web opens the viewers of examples/webgl in a browser. asan builds and runs all but the
# shader tests again, with Clang; plain builds what a user without tests does; clang the kernels, optimised; tsan what has threads;
# libcxx, mingw and aarch64 the unit tests. A training that is compiled is most of a source's time: examples/ntc/encode has them once.
# Heavy stages run when something that they depend on changed since the last landed commit; otherwise they say so and count as
# skipped. Logs are in build/logs. Exit status 0 only if nothing failed and the vectors V1 and V2 ran.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

stages=" ${OPENNTC_STAGES:-release slurm caps compilers web asan clang plain tsan libcxx mingw aarch64 format tidy} "
everything=0
if [[ "$stages" == " all " ]]; then
    everything=1
    stages=" release slurm caps compilers-all web asan clang plain tsan libcxx mingw aarch64 format tidy coverage "
    OPENNTC_TIDY="${OPENNTC_TIDY:-all}"
fi
jobs="$(nproc)"
logs="build/logs"
mkdir -p "$logs"
rm -f "$logs"/*.log "$logs"/*.status "$logs"/lane-*
passed=0
failed=0
skipped=0
failures=()
times=() # "stage part seconds processor-seconds"
started=$SECONDS
spent_cpu=0 # by all that spent() has noted

export CTEST_PARALLEL_LEVEL="$jobs"
# Large pages for malloc: Clang, and LLVM in the Vulkan driver, take a tenth less of the processor. Without effect elsewhere.
export GLIBC_TUNABLES="${GLIBC_TUNABLES:+$GLIBC_TUNABLES:}glibc.malloc.hugetlb=1"
# Stages compile many shaders alike.
export OPENNTC_SHADER_CACHE="${OPENNTC_SHADER_CACHE-$PWD/build/shader-cache}"
export UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1${UBSAN_OPTIONS:+:$UBSAN_OPTIONS}"
# Leaks of the Vulkan driver and loader, and of tinyexr on malformed files, are not ours.
export LSAN_OPTIONS="suppressions=$PWD/tests/support/leaks.supp:print_suppressions=0${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
# Larger unity builds than those of a build folder in which one source changes.
batches=(-DCMAKE_UNITY_BUILD_BATCH_SIZE=48)
shared=()
if [[ -n "${OPENNTC_SHARED_DIR:-}" ]]; then
    shared=("-DOPENNTC_SHARED_DIR=$OPENNTC_SHARED_DIR")
fi

want() { [[ "$stages" == *" $1 "* ]]; }

# The processor seconds, user and system, of every program that has ended.
cpu_seconds() {
    local file="$logs/times-$BASHPID.txt"
    times >"$file" # a built-in of this shell: not in a subshell, which would tell its own
    cpu="$(awk 'NR == 2 { for (i = 1; i <= 2; i++) { split($i, part, /[ms]/); sum += part[1] * 60 + part[2] } print int(sum) }' "$file")"
    rm -f "$file"
}

# spent STAGE PART BEGIN: notes the seconds since BEGIN, and of the processor since the call before this one.
spent() {
    local cpu
    cpu_seconds
    times+=("$1 $2 $((SECONDS - $3)) $((cpu - spent_cpu))")
    spent_cpu="$cpu"
}

# skip_many NUMBER TEXT, skip TEXT: more skipped tests, or one, with their reason.
skip_many() {
    skipped=$((skipped + $1))
    echo "      SKIP: $2"
}
skip() { skip_many 1 "$1"; }

# The commit that changes are measured from. OPENNTC_BASE if set; else where this branch left origin/main. In a fresh clone that
# is HEAD itself, or origin is not there: then the newest commit that is a day older than HEAD, because one landing has many
# commits, of which the parent would show the last alone; else, in a short history, the empty tree: everything changed.
landed_base() {
    local base head
    head="$(git rev-parse -q --verify HEAD 2>/dev/null)" || { git hash-object -t tree /dev/null; return; }
    if [[ -n "${OPENNTC_BASE:-}" ]]; then
        git rev-parse -q --verify "$OPENNTC_BASE^{commit}" && return
        echo "run.sh: OPENNTC_BASE: $OPENNTC_BASE: no such commit; everything counts as changed" >&2
    else
        base="$(git merge-base HEAD origin/main 2>/dev/null || true)"
        if [[ -z "$base" || "$base" == "$head" ]]; then
            base="$(git rev-list -1 --before="$(($(git log -1 --format=%ct) - 86400))" HEAD 2>/dev/null || true)"
        fi
        if [[ -n "$base" ]]; then
            echo "$base"
            return
        fi
    fi
    git hash-object -t tree /dev/null
}

# What differs from the base, committed or not, one path a line; "." (all) outside of a repository.
changed_paths() {
    if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
        echo .
        return
    fi
    git diff --name-only "$base_commit" --
    git ls-files --others --exclude-standard
}

# heavy STAGE PATH…: true if the stage is wanted and something under the paths (or the test command itself) changed.
heavy() {
    local stage="$1" path
    want "$stage" || return 1
    shift
    [[ "$everything" -eq 0 && "$changed" != . ]] || return 0
    for path in "$@" tests/run.sh tests/install.sh tests/CMakeLists.txt CMakePresets.json CMakeLists.txt cmake/; do
        if awk -v path="$path" 'index($0, path) == 1 { found = 1 } END { exit !found }' <<<"$changed"; then
            return 0
        fi
    done
    skip "unchanged: $stage: nothing that it depends on changed since ${base_commit:0:12}; OPENNTC_STAGES=all runs it"
    return 1
}

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

# add_counts STAGE LOG OK: the tests of a CTest log, and what they skipped. OK is 0 if ctest failed.
add_counts() {
    local stage="$1" log="$2" ok="$3" p=0 f=0 k=0
    if [[ -f "$log" ]]; then
        cp "$log" "$logs/$stage-output.log"
        read -r p f k < <(count_tests "$log")
    fi
    if [[ "$ok" -eq 0 && "$f" -eq 0 ]]; then
        f=1 # for example a test that could not be started
    fi
    passed=$((passed + p))
    failed=$((failed + f))
    skipped=$((skipped + k))
    if [[ -f "$log" ]]; then
        grep -avE '^Command: ' "$log" | grep -aoE 'SKIP: .*' | sort | uniq -c | sed "s/^/      $stage: /"
    fi
}

# build_and_test PRESET [LABEL [TARGET]]: everything (but what stage web has), or the tests of one label and one target more.
build_and_test() {
    local preset="$1" log="build/$1/Testing/Temporary/LastTest.log" begin=$SECONDS ok=1
    local build=() tests=(-LE '^web$')
    if [[ $# -gt 1 ]]; then
        build=(--target "tests_$2" ${3:+"$3"})
        tests=(-L "^$2\$")
    fi
    step "$preset-configure" cmake --preset "$preset" "${launcher[@]}" "${batches[@]}" "${shared[@]}" || return
    step "$preset-build" cmake --build --preset "$preset" --parallel "$jobs" "${build[@]}"
    local built=$?
    spent "$preset" build "$begin"
    [[ "$built" -eq 0 ]] || return
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
    spent "$preset" test "$begin"
    add_counts "$preset" "$log" "$ok"
}

# run_binary LOG NAME COMMAND…: appends its output in CTest's form, so that count_tests reads it.
run_binary() {
    local log="$1" name="$2" status
    shift 2
    printf '1/1 Testing: %s\n' "$name" >>"$log"
    "$@" >>"$log" 2>&1 </dev/null
    status=$?
    if [[ "$status" -eq 0 ]]; then echo "Test Passed." >>"$log"; else echo "Test Failed." >>"$log"; fi
    return "$status"
}

# The script that `ntc bake --plan slurm` writes, run by Slurm, when what it is made of changed.
run_slurm() {
    local log="$logs/slurm-tests.log" begin=$SECONDS ok=1
    heavy slurm examples/ntc/bake/ examples/ntc/Bake.cpp examples/ntc/encode/ include/openntc/encode/ tests/slurm.sh || return
    if [[ ! -x build/release/bin/ntc ]]; then
        skip "slurm: needs the release build: OPENNTC_STAGES=\"release slurm\""
        return
    fi
    rm -f "$log"
    if run_binary "$log" slurm bash tests/slurm.sh build/release/bin/ntc; then
        echo "ok    slurm ($((SECONDS - begin)) s)"
    else
        ok=0
        failures+=(slurm)
        echo "FAIL  slurm ($((SECONDS - begin)) s); the end of $log:"
        tail -n 40 "$log"
    fi
    add_counts slurm "$log" "$ok"
    spent slurm test "$begin"
}

# What other shader compilers make of the headers: a script of its own, whose last line has its counts.
run_shader_compilers() {
    local log="$logs/compilers.log" begin=$SECONDS p=0 f=1 k=0 name
    if want compilers-all; then
        bash tests/compilers/run.sh all >"$log" 2>&1 </dev/null
    else
        heavy compilers shaders/ tests/compilers/ examples/shader_compiler/ examples/engines/ docs/shaders.md || return
        bash tests/compilers/run.sh >"$log" 2>&1 </dev/null
    fi
    read -r p f k < <(sed -nE 's/^compilers: ([0-9]+) passed, ([0-9]+) failed, ([0-9]+) skipped.*/\1 \2 \3/p' "$log" | tail -n 1)
    passed=$((passed + ${p:-0}))
    failed=$((failed + ${f:-1}))
    skipped=$((skipped + ${k:-0}))
    name="ok  "
    if [[ "${f:-1}" -ne 0 ]]; then
        name="FAIL"
        failures+=(compilers)
        tail -n 40 "$log"
    fi
    echo "$name  compilers ($((SECONDS - begin)) s)"
    grep -aoE 'SKIP: .*' "$log" | sed 's/^/      /'
    spent compilers test "$begin"
}

# The viewer in the browser, after what that needs (some 400 MB) is installed: when something changed that its decoder, its reader
# or its page is made of.
run_web() {
    local log="build/release/Testing/Temporary/LastTest.log" begin=$SECONDS ok=1
    heavy web examples/webgl/ examples/webgpu/ tests/consumer/webgl/ tests/consumer/webgpu/ shaders/openntc/Inference \
        shaders/openntc/Inputs shaders/openntc/Latent shaders/openntc/Network shaders/openntc/Portability shaders/openntc/StochasticFiltering \
        shaders/openntc/filtering/ include/openntc/core/ include/openntc/inference/ include/openntc/texture_set/ || return
    if [[ ! -x build/release/bin/ntc ]]; then
        skip "web: needs the release build: OPENNTC_STAGES=\"release web\""
        return
    fi
    if ! bash tests/install.sh web >"$logs/web-install.log" 2>&1 </dev/null; then
        skip "web: $(tail -n 1 "$logs/web-install.log")"
        return
    fi
    step web-configure cmake --preset release || return # finds what is new
    rm -f "$log"
    if ctest --preset release -L '^web$' >"$logs/web-tests.log" 2>&1 </dev/null; then
        echo "ok    web tests ($((SECONDS - begin)) s)"
    else
        echo "FAIL  web tests ($((SECONDS - begin)) s); the end of $logs/web-tests.log:"
        tail -n 60 "$logs/web-tests.log"
        failures+=("web-tests")
        ok=0
    fi
    add_counts web "$log" "$ok"
    spent web test "$begin"
}

# One cap of run_caps: its log, and whether all was good. Has a folder for temporary files of its own.
run_cap() {
    local bin="build/release/bin" log="$logs/caps-$1.log" ok=1 TMPDIR
    rm -f "$log"
    TMPDIR="$(mktemp -d)" || return 1
    export OPENNTC_SIMD_CAP="$1" VK_ICD_FILENAMES=/dev/null VK_DRIVER_FILES=/dev/null TMPDIR
    run_binary "$log" unit_core "$bin/unit_core" "-tc=*SIMD*,*OPENNTC_SIMD_CAP*" || ok=0
    run_binary "$log" unit_decode "$bin/unit_decode" "-tc=fast decoder*,checksums*" || ok=0
    run_binary "$log" conformance_backends "$bin/conformance_backends" || ok=0
    # That the cases notice mistakes is tried once, without a cap.
    run_binary "$log" numerics "$bin/numerics" "-tc=hard cases stay*" || ok=0
    run_binary "$log" cli "$bin/cli" "-tc=sample texture sets*" || ok=0
    run_binary "$log" unit_encode "$bin/unit_encode" "-sf=*round_trip_test.cpp,*geometry_test.cpp" || ok=0
    rm -rf "$TMPDIR"
    echo "$ok" >"$logs/caps-$1.status"
}

# The tests whose code depends on the processor, by the release build's binaries, with instruction sets taken away. What the
# processor has at most is what stage release ran with. Without a Vulkan device: that one does not change.
run_caps() {
    local cap log ok begin=$SECONDS caps="none avx2" sets=""
    if [[ ! -x build/release/bin/unit_decode ]]; then
        echo "FAIL  caps: needs the release build: OPENNTC_STAGES=\"release caps\""
        failed=$((failed + 1))
        failures+=(caps)
        return
    fi
    if [[ "$(uname -m)" == x86_64 ]]; then
        sets="$(grep -m1 '^flags' /proc/cpuinfo) "
    fi
    if [[ "$sets" == *" avx512_vnni "* && "$sets" == *" avx_vnni "* ]]; then caps+=" avxvnni"; fi
    if [[ "$sets" == *" amx_int8 "* ]]; then caps+=" avx512"; fi
    # As many at once as there are processors; their results in turn.
    for cap in $caps; do
        while [[ "$(jobs -rp | wc -l)" -ge "$jobs" ]]; do wait -n; done
        run_cap "$cap" &
    done
    wait
    for cap in $caps; do
        log="$logs/caps-$cap.log"
        ok="$(cat "$logs/caps-$cap.status")"
        if [[ "$ok" -eq 1 ]]; then
            echo "ok    caps-$cap"
        else
            echo "FAIL  caps-$cap; from $log:"
            grep -aE -A 4 'ERROR|FATAL' "$log" | head -60
            failures+=("caps-$cap")
        fi
        add_counts "caps-$cap" "$log" "$ok"
    done
    skip "caps: unit_encode's longer trainings at every cap: stage release runs them with the processor's own kernels"
    spent caps test "$begin"
}

# The multi-threaded paths of the command line, on the shipped samples. ThreadSanitizer ends the program with 66 at a race.
tsan_commands() {
    local ntc="$PWD/build/tsan/bin/ntc" data="$PWD/examples/materials/data" work
    work="$(mktemp -d)" || return 1
    export VK_ICD_FILENAMES=/dev/null VK_DRIVER_FILES=/dev/null
    "$ntc" bench decode "$data/bricks.ntc" --backend cpu --repeat 2 &&
        "$ntc" decode "$data/bricks.ntc" -o "$work/decoded" --backend cpu &&
        "$ntc" decode "$data/bricks.ntc" -o "$work/blocks" --backend cpu --format dds --bc auto &&
        "$ntc" encode "$work/decoded" -o "$work/again.ntc" --steps 12 --threads 3 --fp8 &&
        "$ntc" compare "$data/bricks.ntc" "$work/again.ntc" &&
        mkdir "$work/art" && cp -r "$work/decoded" "$work/art/a" && cp -r "$work/decoded" "$work/art/b" &&
        "$ntc" bake "$work/art" -o "$work/baked" --steps 6 --jobs 2 --save-every 0.01 &&
        "$ntc" compile-shaders shaders/openntc/passes/DecodeTexels.comp --network small medium --math int8 \
            --jobs 4 -I shaders --output-dir "$work/shaders"
    local status=$?
    rm -rf "$work"
    return "$status"
}

# Every public header with the other C++ library, all together and then again without exceptions and RTTI.
check_libcxx_headers() {
    local source="$logs/libcxx_headers.cpp" options
    # But for what exists in GLSL, and in HLSL, only (of encode/, C++ shares what encode/TrainingDevice.h takes in), and the block
    # encoders, which bc/BlockEncoder.h takes in several times.
    (cd include && find openntc ../shaders/openntc -name '*.h' ! -name '*Coop*.h' ! -name DecodeStrips.h ! -name MatrixBuffers.h \
        ! -name GDeflateCodes.h ! -name GDeflateGroup.h ! -path '*shaders/openntc/bc/*' \
        ! -path '*shaders/openntc/encode/*' | LC_ALL=C sort |
        sed -E 's,^(\.\./shaders/)?(.*),#include "\2",') >"$source"
    for options in "" "-fno-exceptions -fno-rtti"; do
        # shellcheck disable=SC2086 # several options
        clang++-19 -stdlib=libc++ -std=c++20 -fsyntax-only $options -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror \
            -Iinclude -Ishaders "$source" || return 1
    done
}

# Builds compile several sources as one (unity builds); this writes a command for each of them, for clang-tidy and
# check_sources_alone.
write_commands() {
    mkdir -p "$logs/commands"
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
        END { print "\n]" }' build/release/compile_commands.json >"$logs/commands/compile_commands.json"
}

# Each changed source of the examples and tests by itself, without code: what its neighbours in a unity build include is not there.
# Of the release build, whose generated headers are there. For a while, in any order, unless everything is wanted. Not those that
# clang-tidy has read in this run: it reads each by itself, and an include that is missing is an error there too.
check_sources_alone() {
    local limit=60
    if [[ "$everything" -eq 1 ]]; then
        limit=36000
    fi
    SOURCES_DEADLINE=$(($(date +%s) + limit))
    export SOURCES_DEADLINE
    write_commands
    changed_sources >"$logs/changed_sources.txt"
    if [[ -f "$logs/tidy.log" ]]; then
        sed -n 's/^not reached in time: //p' "$logs/tidy.log" | grep -vxFf - "$logs/tidy_sources.txt" >"$logs/tidied.txt"
        echo "$(wc -l <"$logs/tidied.txt") sources were read by clang-tidy"
        grep -vxFf "$logs/tidied.txt" "$logs/changed_sources.txt" >"$logs/untidied.txt"
        mv "$logs/untidied.txt" "$logs/changed_sources.txt"
    fi
    awk -v list="$logs/changed_sources.txt" '
        BEGIN { while ((getline line <list) > 0) wanted[ENVIRON["PWD"] "/" line] = 1 }
        /^ *"command":/ { command = $0 }
        /^ *"file":/ {
            split($0, part, "\"")
            if (!(part[4] in wanted)) next
            sub(/^ *"command": "/, "", command); sub(/",$/, "", command)
            sub(/^(.* )?[^ ]*\+\+ /, "", command); sub(/ -o [^ ]*/, "", command)
            gsub(/\\"/, "\"", command); gsub(/\\\\/, "\\", command)
            late = "[[ $(date +%s) -ge $SOURCES_DEADLINE ]] && echo \"not reached in time: " part[4] "\" && exit"
            printf "%s; clang++-14 -w -fsyntax-only %s%c", late, command, 0
        }' "$logs/commands/compile_commands.json" | shuf -z | xargs -r -0 -P "$jobs" -n 1 bash -c
}

# What a user builds: no preset, no build type, every target, and from a copy that has no tests. With Clang, which compiles this
# nearly twice as fast; what g++ sees differently, stage release compiles.
build_plain() {
    local source="build/plain/source"
    rm -rf "$source"
    mkdir -p "$source"
    cp -r CMakeLists.txt LICENSE README.md cmake include shaders examples schemas docs "$source/" &&
        cmake --fresh -G Ninja -S "$source" -B build/plain/build -DOPENNTC_BUILD_TESTS=OFF -DCMAKE_CXX_COMPILER=clang++-14 "${launcher[@]}" "${batches[@]}" &&
        cmake --build build/plain/build --parallel "$jobs" --target all bench_gpu
}

# How many lines of include/ the unit tests run.
run_coverage() {
    local raw="build/coverage/profiles" objects=() binary
    rm -rf "$raw"
    export LLVM_PROFILE_FILE="$PWD/$raw/%p.profraw"
    build_and_test coverage
    unset LLVM_PROFILE_FILE
    for binary in build/coverage/bin/unit_*; do objects+=(-object "$binary"); done
    llvm-profdata-14 merge -sparse "$raw"/*.profraw -o build/coverage/unit.profdata &&
        llvm-cov-14 report -instr-profile=build/coverage/unit.profdata "${objects[@]:1}" include >"$logs/coverage.txt" &&
        awk '/^TOTAL/ { print "      coverage of include/ by unit tests: " $10 " of lines, " $7 " of functions" }' \
            "$logs/coverage.txt"
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

# Sources that differ from the last landed commit.
changed_sources() {
    if [[ "${OPENNTC_TIDY:-}" == all || "$changed" == . ]]; then
        sources 'include/*.h' 'shaders/*.h' 'examples/*.h' '*.cpp'
        return
    fi
    git diff --name-only --diff-filter=d "$base_commit" -- '*.h' '*.cpp'
}

tidy_file() {
    if [[ "$SECONDS" -ge "$TIDY_DEADLINE" ]]; then
        echo "not reached in time: $1"
        return 0
    fi
    local report
    report="$(clang-tidy --quiet -p build/logs/commands --extra-arg=-Wno-unknown-warning-option "$1" 2>&1)" && return 0
    echo "$report"
    return 1
}

# The changed public headers are checked through one source that includes them; shader headers through the decoder that compiles
# them as C++ (by themselves several are not).
tidy_headers() {
    local source="$logs/tidy_headers.cpp"
    changed_sources | sed -nE -e 's,^include/(openntc/.*\.h)$,#include "\1",p' \
        -e 's,^shaders/openntc/.*\.h$,#include "openntc/decode/ReferenceDecoder.h",p' | sort -u >"$source"
    [[ ! -s "$source" ]] || clang-tidy --quiet "$source" -- -std=c++20 -Iinclude -Ishaders
}

check_tidy() {
    export -f tidy_file
    local limit=60 status=0
    if [[ -n "${OPENNTC_TIDY:-}" ]]; then
        limit=36000
    fi
    # Every tidy_file runs in a shell of its own, whose SECONDS starts from what it is given here.
    export TIDY_DEADLINE=$(($(date +%s) + limit))
    write_commands
    # The headers, one source that takes a minute, beside the others; without what only Windows compiles, and what includes a
    # header that a test makes of README.
    tidy_headers >"$logs/tidy_headers.txt" 2>&1 &
    changed_sources | sed -n -e '/Windows\.cpp$/d' -e '/^tests\/consumer\/readme\//d' -e '/\.cpp$/p' >"$logs/tidy_sources.txt"
    xargs -r -d '\n' -P "$jobs" -n 1 bash -c 'SECONDS=$(date +%s); tidy_file "$1"' tidy <"$logs/tidy_sources.txt" || status=1
    wait "$!" || status=1
    cat "$logs/tidy_headers.txt"
    return "$status"
}

begin=$SECONDS
step install bash tests/install.sh || exit 1
spent install build "$begin"
base_commit="$(landed_base)"
changed="$(changed_paths)"
echo "      changed paths since ${base_commit:0:12}: $(grep -c . <<<"$changed")"

if want release; then
    build_and_test release
    # No part of `all`: for measuring on GPUs.
    begin=$SECONDS
    step release-bench_gpu cmake --build --preset release --parallel "$jobs" --target bench_gpu
    spent release bench_gpu "$begin"
fi
if want slurm; then run_slurm; fi
if want caps; then run_caps; fi
if want compilers || want compilers-all; then run_shader_compilers; fi
if want web; then run_web; fi
# Two halves of what is left run beside each other: the tail of one stage, which one processor works at, is the next one's gain.
run_sanitized() {
    if heavy asan include/ shaders/ examples/ tests/; then build_and_test asan; fi
}
run_compilers() {
    if heavy clang include/ shaders/ tests/unit/ tests/support/; then build_and_test clang; fi
    if heavy plain include/ shaders/ examples/; then
        begin=$SECONDS
        step plain-build build_plain
        spent plain build "$begin"
    fi
    if heavy tsan include/openntc/core/ include/openntc/decode/ include/openntc/encode/ include/openntc/streaming/ shaders/ examples/ntc/ \
        examples/shader_compiler/ tests/unit/core/ tests/unit/streaming/ tests/unit/decode/ tests/unit/encode/; then
        build_and_test tsan unit ntc
        if [[ -x build/tsan/bin/ntc ]]; then
            begin=$SECONDS
            step tsan-ntc tsan_commands
            spent tsan ntc "$begin"
        fi
    fi
    if heavy libcxx include/ shaders/ tests/unit/ tests/support/; then
        begin=$SECONDS
        step libcxx-headers check_libcxx_headers
        spent libcxx headers "$begin"
        build_and_test libcxx
    fi
    if heavy mingw include/ shaders/ tests/unit/ tests/support/; then build_and_test mingw unit; fi
    if heavy aarch64 include/ shaders/ tests/unit/ tests/support/; then build_and_test aarch64 unit; fi
}
# lane NAME COMMAND: in a shell of its own, whose output and counts take_lane puts to this one's.
lane() {
    local name="$1"
    shift
    (
        passed=0 failed=0 skipped=0 spent_cpu=0
        failures=()
        times=()
        "$@" >"$logs/lane-$name.txt" 2>&1
        declare -p passed failed skipped failures times >"$logs/lane-$name.counts"
    ) &
}
take_lane() {
    local lane="$logs/lane-$1" before
    cat "$lane.txt"
    if [[ ! -f "$lane.counts" ]]; then
        failed=$((failed + 1))
        failures+=("lane-$1")
        return
    fi
    before=("$passed" "$failed" "$skipped")
    local all_failures=("${failures[@]}") all_times=("${times[@]}")
    eval "$(sed 's/^declare -[-a]* //' "$lane.counts")"
    passed=$((passed + before[0]))
    failed=$((failed + before[1]))
    skipped=$((skipped + before[2]))
    failures=("${all_failures[@]}" "${failures[@]}")
    times=("${all_times[@]}" "${times[@]}")
}
echo "      sanitizers and other compilers run beside each other; what they say follows when both have ended, and is in $logs/lane-*.txt"
lane sanitized run_sanitized
lane compilers run_compilers
wait
take_lane sanitized
take_lane compilers
cpu_seconds
spent_cpu="$cpu"
if want format; then
    begin=$SECONDS
    step format check_format
    spent format check "$begin"
fi
if want tidy; then
    begin=$SECONDS
    step tidy check_tidy
    spent tidy check "$begin"
    missed="$(grep -c 'not reached in time' "$logs/tidy.log")"
    if [[ "$missed" -gt 0 ]]; then
        skip_many "$missed" "tidy: $missed files were not reached in time; OPENNTC_TIDY=all has no limit"
    fi
fi
if heavy plain include/ shaders/ examples/ tests/; then
    begin=$SECONDS
    if [[ -f build/release/compile_commands.json ]]; then
        step plain-alone check_sources_alone
        missed="$(grep -c 'not reached in time' "$logs/plain-alone.log")"
        if [[ "$missed" -gt 0 ]]; then
            skip_many "$missed" "plain: $missed sources were not reached in time; OPENNTC_STAGES=all has no limit"
        fi
    else
        skip "plain: sources one by one: they need the release build: OPENNTC_STAGES=\"release plain\""
    fi
    spent plain alone "$begin"
fi
if want coverage; then run_coverage; fi

echo
# What other processors have and this one lacks: here only the test that says so ran.
if compgen -G "$logs/release-output.log" >/dev/null; then
    lacking="$(grep -aoE 'SKIP: .*(amx|avxvnni|avx512vnni|avx2).*' "$logs/release-output.log" |
        grep -aE 'machine|target:|kernel:' | sort | uniq -c)"
    if [[ -n "$lacking" ]]; then
        echo "only processors with these instruction sets can test (times skipped here):"
        sed 's/^/    /' <<<"$lacking"
    fi
fi
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
    if want release && ! grep -aqE "VECTORS ran=[1-9][0-9]* .*name=$vector( |\$)" "$logs"/*-output.log 2>/dev/null; then
        echo "FAIL  vectors $vector did not run"
        failed=$((failed + 1))
        failures+=("vectors-$vector")
    fi
done
echo "seconds per stage (of the processors together: what $jobs idle ones would take is about that by $jobs):"
for entry in "${times[@]}"; do
    read -r stage part seconds cpu <<<"$entry"
    printf '    %-10s %-14s %5d (%d)\n' "$stage" "$part" "$seconds" "$cpu"
done
cpu_seconds
echo "time: $((SECONDS - started)) s ($cpu)"
if [[ ${#failures[@]} -gt 0 ]]; then
    echo "failed: ${failures[*]}"
fi
echo "$passed passed, $failed failed, $skipped skipped"
[[ "$failed" -eq 0 ]]
