#!/bin/sh
# SPDX-License-Identifier: MIT
# wine.sh WINE PROGRAM [ARGUMENT...]: runs a Windows program under Wine, in a Wine folder of the build's own.
# A client that loses Wine's server while it connects ends with "wine client error:0: …": thread 0 has run nothing of the
# program, which therefore starts again, twice at most. What the program itself does, its exit status included, stays as it is.
WINEPREFIX="${WINEPREFIX:-$(cd "$(dirname "$0")/../.." && pwd)/build/wine}" WINEDEBUG=-all
export WINEPREFIX WINEDEBUG
mkdir -p "$WINEPREFIX"
errors="$(mktemp)" || exit 1
trap 'rm -f "$errors"' EXIT
for attempt in 1 2 3; do
    "$@" 2>"$errors"
    status=$?
    cat "$errors" >&2
    if [ "$status" -eq 0 ] || ! grep -q '^wine client error:0: ' "$errors"; then
        break
    fi
    echo "Wine's server was lost before the program began, attempt $attempt of 3" >&2
    sleep 1
done
exit "$status"
