"""Names, versions and licences of the crates that the programs contain, with the texts of the licences.

    tools/packaging/third_party.py aarch64-unknown-linux-musl > third-party.txt

needs cargo; asks no network for crates that were built already.
"""

import json
import pathlib
import subprocess
import sys


NAMES = ("LICEN", "COPYING", "NOTICE", "UNLICENSE")


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout


def compiled_in(target):
    """Name and version of every crate that ends up in one of the programs, those that only the
    compiler runs (procedural macros) included."""
    found = set()
    for program in ["mlrd", "mlr-ga"]:
        tree = cargo("tree", "--locked", "-p", program, "-e", "normal", "--prefix", "none",
                     "--target", target, "--format", "{p}")
        for line in tree.splitlines():
            name, version, *_ = line.split()
            found.add((name, version.removeprefix("v")))
    return found


def main():
    target = sys.argv[1]
    wanted = compiled_in(target)
    metadata = json.loads(cargo("metadata", "--locked", "--format-version", "1", "--filter-platform", target))
    texts = {}
    print("Crates that mlr-ga and mlrd contain, with their licences.\n")
    for package in sorted(metadata["packages"], key=lambda package: package["name"]):
        if package["id"] in metadata["workspace_members"] or (package["name"], package["version"]) not in wanted:
            continue
        folder = pathlib.Path(package["manifest_path"]).parent
        # Sorted, and each text once: hundreds of crates share the Apache licence.
        files = [file for file in sorted(folder.iterdir()) if file.is_file() and file.name.upper().startswith(NAMES)]
        for file in files:
            text = "\n".join(line.rstrip() for line in file.read_text(errors="replace").splitlines())
            texts.setdefault(text.strip(), []).append(f"{package['name']} ({file.name})")
        note = "" if files else " (it comes without a text)"
        print(f"{package['name']} {package['version']}: {package['license'] or 'see below'}{note}")
    for text, users in sorted(texts.items(), key=lambda item: item[1]):
        print("\n" + "=" * 78)
        print("\n".join(users))
        print("-" * 78)
        print(text)


main()
