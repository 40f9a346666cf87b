#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes headers and all that they include of this project as one file.

    python3 cmake/amalgamate.py openntc/openntc.h openntc/decode/FastDecoder.h -o openntc_all.h
    python3 cmake/amalgamate.py openntc/Inference.h --shaders -o openntc_inference.h    # GLSL and HLSL

Headers are looked for in include/ and shaders/. What is not found there (the standard library, RapidJSON, tl::expected, GLM)
stays an #include. Files with `#pragma once` get a guard of macros, since GLSL and HLSL compilers know none for parts of a file;
kernels, which a header includes once for each instruction set, appear as often, with all that they include. The licence stands at
the top.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"')
OPENING = re.compile(r"^\s*#\s*(if|ifdef|ifndef)\b")
CLOSING = re.compile(r"^\s*#\s*endif\b")
GUARD = re.compile(r"^\s*#\s*ifndef\s+(\w+)\s*$")
UNDEFINE = re.compile(r"^\s*#\s*undef\s+(\w+)", re.MULTILINE)


def find_guard(text):
    """The macro by which a file that is included again adds nothing: #ifndef and #define of it before any other condition."""
    at = next((i for i, line in enumerate(text) if OPENING.match(line)), None)
    macro = GUARD.match(text[at]) if at is not None else None
    if macro and re.match(rf"^\s*#\s*define\s+{macro.group(1)}\s*$", text[at + 1]):
        return macro.group(1)
    return None


class Amalgamation:
    def __init__(self, folders):
        self.folders = folders
        self.done = set()  # headers that appear where no condition can take them out
        self.lines = []
        # Guards that a file takes back, to include the guarded ones again.
        self.undefined = set()
        for path in (path for folder in folders for path in folder.rglob("*") if path.is_file()):
            self.undefined.update(UNDEFINE.findall(path.read_text(encoding="utf-8")))

    def find(self, name, includer):
        places = [includer.parent] if includer else []
        for folder in places + self.folders:
            path = folder / name
            if path.is_file():
                return path.resolve()
        return None

    def name_of(self, path):
        for folder in self.folders:
            if path.is_relative_to(folder):
                return path.relative_to(folder).as_posix()
        return path.name

    def add(self, path, depth):
        """`depth`: how many #if are open, guards of files that appear once not counted."""
        if path in self.done:
            return
        text = path.read_text(encoding="utf-8").splitlines()
        name = self.name_of(path)
        once = any(line.strip() == "#pragma once" for line in text)
        guard = find_guard(text)
        self.lines.append(f"// {name}")
        if once:
            macro = "OPENNTC_FILE_" + re.sub(r"\W", "_", name).upper()
            self.lines += [f"#ifndef {macro}", f"#define {macro}"]
        inner = depth - 1 if guard else depth
        for line in text:
            if line.startswith("// SPDX-License-Identifier:") or line.strip() == "#pragma once":
                continue
            include = INCLUDE.match(line)
            other = self.find(include.group(1), path) if include else None
            if other:
                self.add(other, inner)
                continue
            inner += 1 if OPENING.match(line) else -1 if CLOSING.match(line) else 0
            self.lines.append(line.rstrip())
        if once:
            self.lines.append("#endif")
        if depth == 0 and (once or guard) and guard not in self.undefined:
            self.done.add(path)


def without_cpp(text):
    """Leaves out what only C++ compilers see, with unifdef (Debian, Homebrew and others have it)."""
    try:
        run = subprocess.run(["unifdef", "-U__cplusplus"], input=text, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        sys.exit("amalgamate.py: --shaders needs the program unifdef")
    if run.returncode > 1:  # 1: something was left out
        sys.exit(f"amalgamate.py: {run.stderr.strip()}")
    return run.stdout


def make_text(entries, folders, for_shaders=False):
    work = Amalgamation([folder.resolve() for folder in folders])
    for entry in entries:
        path = work.find(entry, None)
        if path is None:
            sys.exit(f"amalgamate.py: {entry}: not found in {', '.join(map(str, folders))}")
        work.add(path, 0)
    licence = (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()
    head = [("// " + line).rstrip() for line in licence]
    head += ["//", f"// One file made by cmake/amalgamate.py of: {', '.join(entries)}", ""]
    text = "\n".join(head + work.lines) + "\n"
    return without_cpp(text) if for_shaders else text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("entries", nargs="+", metavar="HEADER", help="as it is included: openntc/openntc.h")
    parser.add_argument("-o", "--output", required=True, help="the file to write")
    parser.add_argument("-I", dest="folders", action="append", type=pathlib.Path, help="instead of include/ and shaders/")
    parser.add_argument("--shaders", action="store_true", help="leave out what only C++ compilers see")
    arguments = parser.parse_args()
    text = make_text(arguments.entries, arguments.folders or [ROOT / "include", ROOT / "shaders"],
                     arguments.shaders)
    temporary = f"{arguments.output}.{os.getpid()}.tmp"
    with open(temporary, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    os.replace(temporary, arguments.output)


if __name__ == "__main__":
    main()
