#!/usr/bin/env python3
"""Fails where files of a crate import each other in a circle.

usage: circles.py SRC...        each SRC is the `src` folder of a library, or the root file of a command such as `examples/reach/main.rs`

An import is a path that begins with `crate`, `super`, `self` or a module of the file, in a `use` line or in code. It counts for the file that
defines the name: re-exports are followed, and are no imports themselves. Tests and comments do not count.
"""
import re
import sys
from pathlib import Path


def code_of(text):
    """The text without comments, strings and modules of tests."""
    text = re.sub(r'//[^\n]*|/\*.*?\*/|r#"[\s\S]*?"#|"(?:\\[\s\S]|[^"\\])*"', lambda m: '""' if m[0][0] in 'r"' else "", text)
    found = re.search(r"#\[cfg\(test\)\]\s*mod\s+\w+\s*\{", text)  # last in a file by our rules
    return text[: found.start()] if found else text


def uses_of(tree, prefix=()):
    """The (path, name) of each leaf of a `use` tree."""
    tree = tree.strip()
    opened = tree.find("{")
    if opened < 0:
        path, _, name = (part.strip() for part in tree.partition(" as "))
        whole = prefix + tuple(path.split("::"))
        whole = whole[:-1] if whole[-1] == "self" and len(whole) > 1 else whole
        return [(whole, name or whole[-1])]
    prefix += tuple(part for part in tree[:opened].split("::") if part)
    leaves, depth, start = [], 0, opened + 1
    for at in range(opened, len(tree)):
        depth += {"{": 1, "}": -1}.get(tree[at], 0)
        if (depth == 1 and tree[at] == ",") or depth == 0:
            if tree[start:at].strip():
                leaves += uses_of(tree[start:at], prefix)
            start = at + 1
        if depth == 0:
            break
    return leaves


class Crate:
    def __init__(self, src):
        self.files, self.code, self.names, self.children = {}, {}, {}, {}
        root, folder = (src / "lib.rs", src) if src.is_dir() else (src, src.parent)
        self.folder = folder
        self.read(("crate",), root, folder)

    def read(self, module, file, folder):
        """Reads a file, then those of the modules that it declares."""
        code = code_of(file.read_text())
        self.files[module], self.children[module] = file, set()
        self.code[module] = re.sub(r"\buse\s[^;]*;", "", code)
        self.names[module] = {}
        self.imports = getattr(self, "imports", {})
        self.imports[module] = []
        for public, tree in re.findall(r"\b(pub(?:\([^)]*\))?\s+)?use\s([^;]*);", code):
            for path, name in uses_of(tree):
                self.names[module][name] = path
                if not public:
                    self.imports[module].append(path)
        declared = re.findall(r"(#\[cfg\(test\)\]\s*)?(?:pub(?:\([^)]*\))?\s+)?\bmod\s+(\w+)\s*;", code)
        for test, name in declared:
            inner = [folder / f"{name}.rs", folder / name / "mod.rs"]
            inner = [path for path in inner if path.exists()]
            if test:
                continue
            self.children[module].add(name)
            if inner:
                self.read((*module, name), inner[0], folder / name)
            else:  # a file elsewhere, by its path
                self.names[*module, name], self.children[*module, name] = {}, set()

    def file_of(self, module, path, seen=()):
        """The module whose file defines what a path means, or None for what is outside of the crate."""
        at = module
        if (at, path) in seen or len(seen) > 50:  # a name that leads to itself
            return None
        seen += ((at, path),)
        for index, part in enumerate(path):
            if part == "crate":
                at = ("crate",)
            elif part == "super":
                at = at[:-1]
            elif part == "self":
                continue
            elif part in self.children[at]:
                at = (*at, part)
            elif part in self.names[at]:
                return self.file_of(at, self.names[at][part] + tuple(path[index + 1 :]), seen)
            elif index == 0:
                return None
            else:
                return at
        return at

    def edges(self):
        for module, code in self.code.items():
            begins = "|".join(["crate", "super", "self", *sorted(self.children[module])])
            paths = [tuple(path.split("::")) for path in re.findall(rf"(?<![\w:])(?:{begins})(?:::\w+)+", code)]
            for path in paths + self.imports[module]:
                target = self.file_of(module, path)
                if target and target != module:
                    yield module, target


def circles(edges):
    """The strongly connected sets of more than one node (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in edges.get(node, ()):
            if other not in index:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == index[node]:
            found.append(stack[stack.index(node) :])
            del stack[stack.index(node) :]

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return [sorted(nodes) for nodes in found if len(nodes) > 1]


sys.setrecursionlimit(10_000)
bad = 0
for src in map(Path, sys.argv[1:]):
    crate, edges = Crate(src), {}
    for module, target in crate.edges():
        edges.setdefault(module, set()).add(target)
    for nodes in circles({node: sorted(targets) for node, targets in edges.items()}):
        bad += 1
        print(f"{src}: a circle of {len(nodes)} files")
        for node in nodes:
            others = ", ".join("::".join(other[1:]) or "lib" for other in sorted(edges[node]) if other in nodes)
            print(f"  {crate.files[node].relative_to(crate.folder)} -> {others}")
sys.exit(bad > 0)
