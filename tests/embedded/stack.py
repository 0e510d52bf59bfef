#!/usr/bin/env python3
"""Bound of the stack that a function needs, from gcc's call graphs.   SPDX-License-Identifier: MIT

    gcc -fcallgraph-info=su ...          writes a FILE.ci beside each object
    stack.py FUNCTION FILE.ci...         prints the bytes, and the chain of calls that needs them

Fails on recursion, on frames of unknown size, and on calls through pointers. Functions that no file defines (those of
libgcc) count as 0: what is measured on the device covers them.
"""
import re
import sys

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
FRAME = re.compile(r'(\d+) bytes \((\w+)')


def read(paths):
    """Frame of each function that is defined, and the functions that each one calls."""
    frames, calls = {}, {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for title, label in NODE.findall(text):
            frame = FRAME.search(label)
            if frame and frame[2] != "static":
                sys.exit(f"stack.py: {title}: the frame's size is {frame[2]}")
            if frame:
                frames[title] = int(frame[1])
        for source, target in EDGE.findall(text):
            calls.setdefault(source, set()).add(target)
    return frames, calls


def deepest(function, frames, calls, path, known):
    """(bytes, chain) of the deepest chain of calls from the function on."""
    if function in path:
        sys.exit(f"stack.py: {function} calls itself")
    if function == "__indirect_call":
        sys.exit(f"stack.py: {path[-1]} calls through a pointer")
    if function not in known:
        below = [deepest(f, frames, calls, path + [function], known) for f in sorted(calls.get(function, ()))]
        most, chain = max(below, default=(0, []), key=lambda b: b[0])
        known[function] = frames.get(function, 0) + most, [function] + chain
    return known[function]


def main():
    function, paths = sys.argv[1], sys.argv[2:]
    frames, calls = read(paths)
    if function not in frames:
        sys.exit(f"stack.py: no function {function}")
    total, chain = deepest(function, frames, calls, [], {})
    print(total, " ".join(f"{name.split(':')[-1]}:{frames.get(name, 0)}" for name in chain))


if __name__ == "__main__":
    main()
