#!/usr/bin/env python3
"""Draw every model file of a folder with fragloom, and say what became of each.

For every file below DIR whose ending fragloom reads (.obj .gltf .glb .ply
.stl .pcd, and each of them followed by .gz) this runs

    FRAGLOOM render FILE --size 64x64 -m z-buffer --json -q

and prints one line, in the order of the files' names:

    drawn            the picture has fragments, and there was nothing to warn of
    warned           it has fragments, and there were warnings
    nothing in view  the file was read, but the picture has no fragment
    refused          fragloom said why it does not draw the file (exit code 1 or 2)
    panicked         it ended in another way, or wrote "panicked", or its answer
                     is not JSON
    timed out        it took longer than --timeout
    not there        the file, or a buffer that a .gltf names, is only a pointer of
                     Git LFS, so it was not drawn

A summary follows: how many files of each kind and of each format, and the
messages, most frequent first, in which <file>, <name> and <n> stand for file
names, for what is in quotes, and for numbers.

The exit code is 1 if a file panicked or timed out, 2 if the program or the
folder is not there, otherwise 0: a file that is refused is no failure here.
"""

import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import time
import urllib.parse

ENDINGS = ("obj", "gltf", "glb", "ply", "stl", "pcd")
KINDS = (
    "drawn",
    "warned",
    "nothing in view",
    "refused",
    "panicked",
    "timed out",
    "not there",
)
LFS = b"version https://git-lfs"


def format_of(name):
    """The ending that says how to read a file, like "obj.gz"; else None."""
    lower = name.lower()
    packed = ""
    if lower.endswith(".gz"):
        lower, packed = lower[:-3], ".gz"
    stem, dot, ending = lower.rpartition(".")
    return ending + packed if dot and ending in ENDINGS else None


def model_files(folder):
    """Paths of all model files below a folder, relative to it, sorted."""
    found = []
    for where, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name != ".git"]
        for name in names:
            path = os.path.join(where, name)
            if format_of(name) and os.path.isfile(path):
                found.append(os.path.relpath(path, folder))
    return sorted(found)


def is_lfs_pointer(path):
    with open(path, "rb") as file:
        return file.read(len(LFS)) == LFS


def lacks_buffer(path):
    """Whether a .gltf names a buffer that is only a pointer."""
    try:
        with open(path, "rb") as file:
            buffers = json.loads(file.read()).get("buffers", [])
        names = [str(buffer.get("uri", "data:")) for buffer in buffers]
        names = [urllib.parse.unquote(name) for name in names if not name.startswith("data:")]
        paths = [os.path.join(os.path.dirname(path), name) for name in names]
        return any(is_lfs_pointer(path) for path in paths if os.path.isfile(path))
    # Whatever is wrong with the file is for fragloom to say.
    except (OSError, ValueError, AttributeError, TypeError):
        return False


def text(data):
    return data.decode("utf-8", "replace").strip()


def draw(fragloom, folder, name, timeout):
    """Draw one file. Returns what became of it, as a dictionary."""
    path = os.path.join(folder, name)
    result = {
        "file": name,
        "format": format_of(name),
        "kind": "not there",
        "messages": [],
        "seconds": 0.0,
    }
    try:
        if is_lfs_pointer(path):
            return result
        if result["format"] == "gltf" and lacks_buffer(path):
            result["messages"] = ["a buffer is only a pointer"]
            return result
    except OSError as error:
        result["messages"] = [str(error)]
        return result

    command = [
        fragloom,
        "render",
        path,
        "--size",
        "64x64",
        "-m",
        "z-buffer",
        "--json",
        "-q",
    ]
    start = time.monotonic()
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=timeout,
        )
    except subprocess.TimeoutExpired:
        result["kind"] = "timed out"
        result["messages"] = ["longer than %g s" % timeout]
        return result
    finally:
        result["seconds"] = round(time.monotonic() - start, 3)

    errors = [line for line in text(done.stderr).splitlines() if line.strip()]
    result["exit"] = done.returncode
    if done.returncode not in (0, 1, 2) or any("panicked" in line for line in errors):
        result["kind"] = "panicked"
        result["messages"] = errors or ["exit code %d" % done.returncode]
        return result

    try:
        answer = json.loads(done.stdout)
    except ValueError:
        answer = None
    if done.returncode != 0:
        result["kind"] = "refused"
        # The line that says why, without warnings that came before it.
        first = [i for i, line in enumerate(errors) if line.startswith("error")]
        reasons = errors[first[0] :] if first else errors
        if not reasons and answer:
            reasons = [str(line) for line in answer.get("violations", [])]
        result["messages"] = ["\n".join(reasons) or "exit code %d" % done.returncode]
        return result
    if not isinstance(answer, dict):
        result["kind"] = "panicked"
        result["messages"] = ["the answer is not JSON"] + errors
        return result

    # Warnings are in the JSON, and may be on stderr as well.
    warnings = [
        line if isinstance(line, str) else json.dumps(line)
        for line in answer.get("warnings", [])
    ]
    for line in errors:
        if not any(warning in line for warning in warnings):
            warnings.append(line)
    for key in ("triangles", "points", "degenerate", "generated"):
        if key in answer:
            result[key] = answer[key]
    result["messages"] = warnings
    if answer.get("generated", 0) == 0:
        result["kind"] = "nothing in view"
    else:
        result["kind"] = "warned" if warnings else "drawn"
    return result


def group_of(message, folder, name):
    """A message without what differs from file to file."""
    path = os.path.join(folder, name)
    message = re.sub(r"^(error|warning): ", "", message)
    for known in (path, name, os.path.basename(name)):
        message = message.replace(known, "<file>")
    # Files beside this one, like buffers; pictures; what a line of an OBJ file says.
    beside = re.escape(os.path.dirname(path)) + r"[/\\].*?(?=: |$)"
    message = re.sub(beside, "<file>", message)
    message = re.sub(r"\b(map_\w+) .*?(?=: )", r"\1 <name>", message)
    message = re.sub(r"(?<=: )(f|l|p|v|vn|vt) [^:]*(?=: )", r"\1 <n>", message)
    message = re.sub(r'"[^"\n]*"', '"<name>"', message)
    message = re.sub(r"`[^`\n]*`", "`<name>`", message)
    message = re.sub(r"'[^'\n]*'", "'<name>'", message)
    number = r"[-+]?\d+(,\d{3})*(\.\d+)?([eE][-+]?\d+)?"
    message = re.sub(r"\b\d+\.\.\d+\b", "<n>", message)
    return re.sub(r"(?<![\w.])" + number + r"(?!\w)", "<n>", message)


def show_groups(title, results, folder, kinds):
    groups = {}
    for result in results:
        if result["kind"] not in kinds:
            continue
        for group in {group_of(m, folder, result["file"]) for m in result["messages"]}:
            groups.setdefault(group, []).append(result["file"])
    if not groups:
        return
    print("\n%s, by message:" % title)
    for group, files in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        print("%6d  %s" % (len(files), group.replace("\n", "\n        ")))
        print("        first: %s" % files[0])


def show_summary(results, folder):
    kinds = [kind for kind in KINDS if any(r["kind"] == kind for r in results)]
    formats = sorted({r["format"] for r in results})
    rows = [["format"] + kinds + ["all"]]
    for format in formats + [None]:
        these = [r for r in results if format in (None, r["format"])]
        counts = [sum(r["kind"] == kind for r in these) for kind in kinds]
        rows.append([format or "all"] + counts + [len(these)])
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    print()
    for row in rows:
        cells = [str(row[0]).ljust(widths[0])]
        cells += [str(cell).rjust(width) for cell, width in zip(row[1:], widths[1:])]
        print("  ".join(cells))
    show_groups("panicked and timed out", results, folder, ("panicked", "timed out"))
    show_groups("refused", results, folder, ("refused",))
    show_groups("nothing in view", results, folder, ("nothing in view",))
    show_groups("warnings", results, folder, ("warned",))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("fragloom", metavar="FRAGLOOM", help="the program to run")
    parser.add_argument("folder", metavar="DIR", help="the folder that is searched")
    parser.add_argument(
        "--jobs",
        type=int,
        default=1,
        metavar="N",
        help="files drawn at the same time; each uses all cores (default: 1)",
    )
    parser.add_argument(
        "--timeout",
        type=float,
        default=60.0,
        metavar="S",
        help="seconds after which a file is given up (default: 60)",
    )
    parser.add_argument(
        "--json",
        metavar="FILE",
        help="write what became of every file to FILE, as a JSON list",
    )
    args = parser.parse_args()
    if args.jobs < 1:
        parser.error("--jobs: at least 1")
    if not args.timeout > 0:
        parser.error("--timeout: more than 0")
    if not os.path.isdir(args.folder):
        parser.error("%s: there is no such folder" % args.folder)
    sys.stdout.reconfigure(errors="backslashreplace")
    fragloom = os.path.abspath(args.fragloom)
    if not os.access(fragloom, os.X_OK) or os.path.isdir(fragloom):
        parser.error("%s: there is no such program" % args.fragloom)

    results = []
    names = model_files(args.folder)
    if not names:
        print("no model file in %s" % args.folder)
        return 0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        jobs = [
            pool.submit(draw, fragloom, args.folder, name, args.timeout)
            for name in names
        ]
        # In the order of the names, whichever ends first.
        for job in jobs:
            result = job.result()
            results.append(result)
            line = "%-15s  %s" % (result["kind"], result["file"])
            if result["messages"]:
                line += ": " + " | ".join(result["messages"])
            # On one line, whatever is in a file's name or in a message.
            print(" ".join(line.splitlines()), flush=True)
    show_summary(results, args.folder)
    if args.json:
        with open(args.json, "w", encoding="utf-8", errors="replace") as file:
            json.dump(results, file, indent=1)
            file.write("\n")
    return 1 if any(r["kind"] in ("panicked", "timed out") for r in results) else 0


if __name__ == "__main__":
    sys.exit(main())
