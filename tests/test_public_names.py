"""Holds that what a module shows is used: a name that nobody else has is private, or gone."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import lrsr
from lrsr.cli import _COMMANDS

PACKAGE = Path(lrsr.__file__).parent
ROOT = PACKAGE.parent
STABLE = {
    "lrsr.evaluation.delong.AucComparison",
    "lrsr.evaluation.delong.AucEstimate",
    "lrsr.evaluation.delong.compare_aucs",
    "lrsr.evaluation.delong.estimate_auc",
    "lrsr.identities.morphable.sample_head",
    "lrsr.rendering.renderer.render",
    "lrsr.camera.camera.Camera",
    "lrsr.sr.upscaler.Upscaler",
    "lrsr.recognition.engine.Engine",
}
"""What scripts of others may rely on, whether or not we use it ourselves."""
KEPT = {
    "lrsr.identities.hair.build_anchors.main": "makes an asset: run by python -m",
    "lrsr.identities.shape.build_basis.main": "the same",
    "lrsr.identities.photographs.build_space.main": "the same",
} | {f"lrsr.tasks.run_{name.replace('-', '_')}": "the command's" for name in _COMMANDS}
"""Names that no text has, and why they are public nevertheless."""
Definition = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax of every module by its name; a folder's __init__ has the folder's."""
    return {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): ast.parse(
            file.read_text()
        )
        for file in sorted(PACKAGE.rglob("*.py"))
    }


def definitions(tree: ast.Module) -> dict[str, Definition]:
    """What a module defines at its top, private names too."""
    found: dict[str, Definition] = {}
    for node in tree.body:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                found[name] = node
            case ast.AnnAssign(target=ast.Name(id=name)):
                found[name] = node
            case ast.Assign(targets=targets):
                for target in targets:
                    names = [item.id for item in ast.walk(target) if isinstance(item, ast.Name)]
                    found |= dict.fromkeys(names, node)
    return found


def public(module: str) -> set[str]:
    return {
        name
        for name in definitions(trees()[module])
        if not name.startswith("_") and name != "logger"  # as Python's guide to logging calls it
    }


@cache
def known() -> set[str]:
    """Every public name with its module: lrsr.evaluation.delong.estimate_auc."""
    return {f"{module}.{name}" for module in trees() for name in public(module)}


@cache
def homes() -> dict[str, set[str]]:
    """What a folder hands on under its own name, and the modules of that folder that have it."""
    handed: dict[str, set[str]] = {}
    for name in known():
        *folders, _, own = name.split(".")
        for depth in range(1, len(folders) + 1):
            handed.setdefault(".".join([*folders[:depth], own]), set()).add(name)
    return handed


def resolve(name: str) -> set[str]:
    """The public names that a dotted name may mean; none where it is not of ours."""
    return {name} if name in known() else homes().get(name, set())


def uses(tree: ast.Module) -> Iterator[str]:
    """The dotted names that a module uses: imported, through a module, or in a string."""
    nodes = [*ast.walk(tree)]  # once: half of this test's time
    bound = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in nodes
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        match node:
            case ast.Name(id=name) if name in bound:
                yield bound[name]
            case ast.Attribute(value=ast.Name(id=name), attr=own):
                yield f"{bound.get(name, name)}.{own}"
            case ast.Constant(value=str(text)) if id(node) not in docstrings:
                yield from re.findall(r"lrsr(?:\.\w+)+", text)
                for name in bound.keys() & set(re.findall(r"\w+", text)):
                    yield bound[name]  # a quoted annotation


@cache
def pages() -> str:
    """All that is written for users: the configuration, the guides and the notebooks."""
    files = [*ROOT.glob("*.md")]
    for folder in ("conf", "docs", "notebooks"):
        files += [file for file in (ROOT / folder).rglob("*") if file.suffix in _TEXTS]
    return "\n".join(file.read_text() for file in files if file.name != "CHANGELOG.md")


_TEXTS = {".md", ".py", ".yaml", ".ipynb"}


def used_elsewhere() -> set[str]:
    """The public names that another module, the configuration or a page has."""
    used = set(STABLE) | set(KEPT)
    for module, tree in trees().items():
        for name in uses(tree):
            used |= {own for own in resolve(name) if own.rsplit(".", 1)[0] != module}
    words = set(re.findall(r"[\w.]+", pages()))
    plain = {word.rsplit(".", 1)[-1] for word in words}
    for word in words:
        used |= resolve(word.rstrip("."))
    return used | {
        name for name in known() if "_" in (own := name.rsplit(".", 1)[1]) and own in plain
    }


def shown(node: Definition) -> Iterator[str]:
    """The names that a definition shows to its user: types, bases, and what it raises."""
    match node:
        case ast.FunctionDef():
            every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            every += [each for each in (node.args.vararg, node.args.kwarg) if each]
            for part in (*(each.annotation for each in every), node.returns):
                yield from names_in(part)
            yield from raised(node)
        case ast.ClassDef():
            for base in node.bases:
                yield from names_in(base)
            for item in node.body:
                if isinstance(item, ast.FunctionDef | ast.AnnAssign):
                    yield from shown(item)
        case ast.AnnAssign():
            yield from names_in(node.annotation)
            yield from names_in(node.value)
        case ast.Assign():
            yield from names_in(node.value)


def names_in(node: ast.AST | None) -> Iterator[str]:
    for each in ast.walk(node) if node else ():
        if isinstance(each, ast.Name):
            yield each.id
        elif isinstance(each, ast.Constant) and isinstance(each.value, str):
            yield from re.findall(r"\w+", each.value)


def raised(node: ast.AST) -> Iterator[str]:
    for each in ast.walk(node):
        if isinstance(each, ast.Raise) and isinstance(each.exc, ast.Call):
            yield from names_in(each.exc.func)


def test_a_public_name_is_used_outside_its_module() -> None:
    used = used_elsewhere()
    waiting = list(used)
    while waiting:
        module, own = waiting.pop().rsplit(".", 1)
        mine = definitions(trees().get(module, ast.Module([], [])))
        for name in shown(mine[own]) if own in mine else ():
            full = f"{module}.{name}"
            if name in mine and full not in used:
                used.add(full)
                waiting.append(full)
    assert known() - used == set()
