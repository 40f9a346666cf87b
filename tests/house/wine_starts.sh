#!/bin/sh
# SPDX-License-Identifier: MIT
# wine_starts.sh WINE.SH FOLDER: a program starts again if Wine lost its server before the program began, and never otherwise.
launcher="$1"
folder="$2"
rm -rf "$folder"
mkdir -p "$folder" || exit 1
export WINEPREFIX="$folder/prefix"
cat >"$folder/wine" <<'END'
#!/bin/sh
# LOST starts fail as Wine's do; the next runs "the program".
starts=$(($(cat "$FOLDER/starts") + 1))
echo "$starts" >"$FOLDER/starts"
if [ "$starts" -le "$LOST" ]; then
    echo "wine client error:$THREAD: recvmsg: Connection reset by peer" >&2
    exit 1
fi
echo "ran: $*"
exit "$STATUS"
END
chmod +x "$folder/wine"
# expect NAME LOST THREAD STATUS  EXPECTED_STATUS EXPECTED_STARTS EXPECTED_OUTPUT
expect() {
    echo 0 >"$folder/starts"
    output="$(FOLDER="$folder" LOST="$2" THREAD="$3" STATUS="$4" sh "$launcher" "$folder/wine" 'a b' c 2>"$folder/errors")"
    status=$?
    starts="$(cat "$folder/starts")"
    if [ "$status" -ne "$5" ] || [ "$starts" -ne "$6" ] || [ "$output" != "$7" ]; then
        echo "$1: status $status, $starts starts, output '$output'; expected $5, $6, '$7'"
        cat "$folder/errors"
        exit 1
    fi
}
expect "runs" 0 0 0 0 1 "ran: a b c"
expect "a failure of the program itself" 0 0 7 7 1 "ran: a b c"
expect "a lost server" 1 0 0 0 2 "ran: a b c"
expect "a lost server, twice" 2 0 7 7 3 "ran: a b c"
expect "no server at all" 9 0 0 1 3 ""
expect "lost while the program runs" 9 2c 0 1 1 ""
