#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Builds the documentation site: README, docs/ and the headers, with MkDocs and Doxygen.

    python3 cmake/site/make_site.py -o build/site        # open build/site/html/index.html

A link between pages that leads nowhere, or a comment that Doxygen cannot read, is an error.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
LINK = re.compile(r"(\]\()([^)#\s]+)((?:#[^)]*)?\))")


class Stage:
    """The pages as MkDocs wants them: README as index.md, docs/ at the top, files of the tree that pages link to in files/."""

    def __init__(self, folder):
        self.folder = folder
        self.broken = []

    def place(self, target):
        """Where the site has a file of the tree."""
        if target == ROOT / "README.md":
            return pathlib.Path("index.md")
        if target.is_relative_to(ROOT / "docs"):
            return target.relative_to(ROOT / "docs")
        if target.suffix == ".md":
            return target.relative_to(ROOT)
        return pathlib.Path("files") / (target.relative_to(ROOT).as_posix().replace("/", ".") + ".txt")

    def rewrite(self, page):
        def link(match):
            address = match.group(2)
            if re.match(r"[a-z]+:", address):
                return match.group(0)
            target = (page.parent / address).resolve()
            if not target.is_relative_to(ROOT) or not target.exists():
                self.broken.append(f"{page.relative_to(ROOT)}: {address}: there is no such file")
                return match.group(0)
            place = self.place(target)
            if target.is_dir():
                place = next((place / name for name in ("README.md", "report.html", "index.html") if (target / name).exists()), place)
            elif not target.is_relative_to(ROOT / "docs"):
                self.copy(target, place)
            up = "../" * (len(self.place(page).parts) - 1)
            return match.group(1) + up + place.as_posix() + match.group(3)

        return LINK.sub(link, page.read_text(encoding="utf-8"))

    def copy(self, source, place):
        target = self.folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.suffix == ".md":
            target.write_text(self.rewrite(source), encoding="utf-8")
        else:
            shutil.copyfile(source, target)

    def make(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(ROOT / "docs", self.folder)
        for page in [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]:
            self.copy(page, self.place(page))
        return self.broken


def make_api(output):
    text = (HERE / "Doxyfile").read_text(encoding="utf-8")
    version = re.search(r"project\(openntc VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
    text += f"PROJECT_NUMBER = {version}\nOUTPUT_DIRECTORY = {output / 'source'}\n"
    return subprocess.run(["doxygen", "-"], input=text, text=True, cwd=ROOT, check=False).returncode


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--no-api", action="store_true", help="pages only, which takes two seconds")
    output = (arguments := parser.parse_args()).output.resolve()
    for program in ["mkdocs"] + ([] if arguments.no_api else ["doxygen"]):
        if shutil.which(program) is None:
            sys.exit(f"make_site.py: {program} is not installed")
    output.mkdir(parents=True, exist_ok=True)
    broken = Stage(output / "source").make()
    if broken:
        sys.exit("\n".join(broken))
    shutil.copyfile(HERE / "mkdocs.yml", output / "mkdocs.yml")
    if arguments.no_api:
        (output / "source" / "api").mkdir()
        (output / "source" / "api" / "index.html").write_text("Left out by --no-api.\n", encoding="utf-8")
    elif make_api(output) != 0:
        return 1
    code = subprocess.run(["mkdocs", "build", "--strict", "--quiet", "--clean"], cwd=output, check=False).returncode
    if code == 0:
        print(output / "html" / "index.html")
    return code


if __name__ == "__main__":
    sys.exit(main())
