"""Prints the reference of the package `phalanx` as Markdown, from its signatures, annotations and docstrings.

python3 tests/book/python_reference.py python/src/phalanx

The sources are parsed, not imported, so that neither the shared library nor NumPy has to be there.
"""

from __future__ import annotations

import ast
import re
import sys
from itertools import zip_longest
from pathlib import Path

#: The public modules, in the order of a reader: name of the file, title.
MODULES = [
    ("running", "Runs"),
    ("log", "Logs"),
    ("metrics", "Metrics and assertions"),
    ("plot", "Plots"),
    ("participant", "Programs in the place of a participant"),
    ("libm", "Mathematics"),
]
#: Modules of which everything that they export is shown.
WHOLE = {"plot", "libm", "participant"}
#: Classes that a program makes by itself, so that their constructor is shown.
CONSTRUCTED = {"participant.Participant"}
#: Decorators of what is an attribute to the reader.
PROPERTIES = {"property", "cached_property", "setter"}
#: Operators that belong to the interface; other names with underscores do not.
OPERATORS = {"__getitem__", "__iter__", "__len__", "__float__", "__bool__", "__enter__", "__fspath__"}


def text(docstring: str | None) -> str:
    """A docstring as Markdown: examples become blocks, double back-ticks single ones."""
    if not docstring:
        return ""
    lines: list[str] = []
    in_example = False
    for line in docstring.splitlines():
        is_example = line.startswith((">>>", "..."))
        if is_example != in_example:
            lines += ["```python"] if is_example else ["```"]
            in_example = is_example
        lines.append(re.sub(r"^(>>>|\.\.\.) ?", "", line) if is_example else re.sub(r"``([^`]+)``", r"`\1`", line))
    if in_example:
        lines.append("```")
    # A command below an example is code as well.
    return "\n".join(lines).replace("and then: phalanx", "and then\n\n    phalanx").strip()


class Module:
    """One file of the package."""

    def __init__(self, path: Path) -> None:
        source = path.read_text(encoding="utf-8")
        self.name = path.stem
        self.lines = source.splitlines()
        self.tree = ast.parse(source)

    def value(self, name: str) -> ast.expr | None:
        """What is assigned to a name of the module."""
        for node in self.tree.body:
            if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == name for t in node.targets):
                return node.value
        return None

    def exported(self) -> list[str]:
        """The names in `__all__`; without it, all variables that have no underscore."""
        if (names := self.value("__all__")) is not None:
            return list(ast.literal_eval(names))
        return [node.target.id for node in self.tree.body if isinstance(node, ast.AnnAssign) and is_public(node.target)]

    def comment_above(self, node: ast.stmt) -> str:
        """The `#:` comment above a name."""
        found: list[str] = []
        for line in reversed(self.lines[: node.lineno - 1]):
            if not line.strip().startswith("#:"):
                break
            found.insert(0, line.strip()[2:].strip())
        return " ".join(found)


def assigned(node: ast.stmt) -> str | None:
    """The name that a statement gives a value, if it does just that."""
    match node:
        case ast.AnnAssign(target=ast.Name(id=name)) | ast.Assign(targets=[ast.Name(id=name)]):
            return name
    return None


def is_public(target: ast.expr) -> bool:
    return isinstance(target, ast.Name) and not target.id.startswith("_")


def signature(function: ast.FunctionDef, is_method: bool) -> str:
    """`name(argument: type = default) -> type`, an argument a line if it is long."""
    parts = pieces(ast.unparse(function.args), ",")
    if is_method and not is_static(function):
        parts = parts[1:]
    # Python's own printer leaves no space around the sign where there is an annotation.
    parts = [" = ".join(pieces(part, "=")) if ":" in part else part for part in parts]
    result = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    line = f"{function.name}({', '.join(parts)}){result}"
    if len(line) <= 100:
        return line
    return f"{function.name}(\n" + "".join(f"    {part},\n" for part in parts) + f"){result}"


def pieces(code: str, separator: str) -> list[str]:
    """Splits code at a character, but not within brackets."""
    parts, depth = [""], 0
    for character in code:
        depth += (character in "([{") - (character in ")]}")
        if character == separator and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]


def decorators(function: ast.FunctionDef) -> set[str]:
    return {ast.unparse(decorator).rpartition(".")[2] for decorator in function.decorator_list}


def is_static(function: ast.FunctionDef) -> bool:
    return "staticmethod" in decorators(function)


def attributes(module: Module, body: list[ast.stmt]) -> list[str]:
    """Rows of a table: name, type, what it is."""
    rows = []
    for node, following in zip_longest(body, body[1:]):
        if isinstance(node, ast.AnnAssign) and is_public(node.target):
            meaning = module.comment_above(node)
            if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
                meaning = str(following.value.value)
            code = ast.unparse(node.value) if node.value else ""
            # What a private name gives is no default that a reader could write.
            default = f" = {code}" if code and code[0] != "_" else ""
            rows.append(row(ast.unparse(node.target), ast.unparse(node.annotation) + default, meaning))
        elif isinstance(node, ast.Assign) and is_public(node.targets[0]):
            rows.append(row(ast.unparse(node.targets[0]), ast.unparse(node.value), module.comment_above(node)))
        elif isinstance(node, ast.FunctionDef) and decorators(node) & PROPERTIES - {"setter"} and node.name[0] != "_":
            annotation = ast.unparse(node.returns) if node.returns else ""
            rows.append(row(node.name, annotation, ast.get_docstring(node) or ""))
    return rows


def row(name: str, annotation: str, meaning: str) -> str:
    cells = (f"`{name}`", f"`{annotation}`" if annotation else "", text(" ".join(meaning.split())))
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def table(rows: list[str]) -> list[str]:
    return ["", "| name | type | meaning |", "|---|---|---|", *rows] if rows else []


def function_section(function: ast.FunctionDef, title: str, heading: str, is_method: bool) -> list[str]:
    code = signature(function, is_method)
    return ["", f"{heading} `{title}`", "", "```python", code, "```", "", text(ast.get_docstring(function))]


def class_section(module: Module, node: ast.ClassDef, title: str) -> list[str]:
    public = [base for base in map(ast.unparse, node.bases) if base[0] != "_"]
    bases = f"({', '.join(public)})" if public else ""
    lines = ["", f"### `{title}`", "", "```python", f"class {node.name}{bases}", "```", ""]
    lines += [text(ast.get_docstring(node)), *table(attributes(module, node.body))]
    for function in node.body:
        if not isinstance(function, ast.FunctionDef) or decorators(function) & PROPERTIES:
            continue
        is_documented = function.name in OPERATORS and ast.get_docstring(function)
        is_constructor = function.name == "__init__" and f"{module.name}.{node.name}" in CONSTRUCTED
        if function.name[0] != "_" or is_documented or is_constructor:
            lines += function_section(function, f"{node.name}.{function.name}", "####", is_method=True)
    return lines


def is_exception(node: ast.stmt) -> bool:
    """Whether it is an exception; these come last."""
    return isinstance(node, ast.ClassDef) and any(ast.unparse(base).endswith(("Error", "Exception")) for base in node.bases)


def main() -> None:
    package = Path(sys.argv[1])
    top = set(ast.literal_eval(Module(package / "__init__.py").value("_HOMES")))
    for name, title in MODULES:
        module = Module(package / f"{name}.py")
        lines = ["", f"## {title}", "", text(ast.get_docstring(module.tree))]
        # Of a module that is shown as a whole, all exported names; of the others, those that the package exports.
        is_whole = name in WHOLE
        shown = [one for one in module.exported() if is_whole or one in top]
        prefix = f"phalanx.{name}" if name in top or name == "libm" else "phalanx"
        values = [node for node in module.tree.body if assigned(node) in shown]
        lines += table(attributes(module, values))
        for node in sorted(module.tree.body, key=is_exception):
            if isinstance(node, ast.ClassDef) and node.name in shown:
                lines += class_section(module, node, f"{'phalanx' if node.name in top else f'phalanx.{name}'}.{node.name}")
            elif isinstance(node, ast.FunctionDef) and node.name in shown:
                lines += function_section(node, f"{prefix}.{node.name}", "###", is_method=False)
        print("\n".join(lines))


if __name__ == "__main__":
    main()
