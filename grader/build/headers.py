"""Declarations for cffi and a shim in C, both derived from the given headers.

The headers are preprocessed with the flags of the build; of the text, the lines that come from our
own headers are kept; bodies of functions are dropped; pycparser reads the rest. There is no copy by
hand.

The shim is compiled into the library. It holds
- `mrt_call_NAME` for each function: it fills the stack (paint.c), and calls it. So one that is
  `static inline`, which a library does not export, can be called too. A struct with an anonymous
  union cannot pass by value through cffi in ABI mode: the wrapper takes its address instead, and
  for a result the address of where to put it, as its first parameter;
- `mrt_layout`, sizeof and offsetof of every struct, compared with cffi's when the library is
  loaded;
- `mrt_constants`, the values of the headers' `#define`s and enumerators;
- `mrt_watch` of watch.c, which notes where the code is when a signal comes;
- `mrt_renew` of renew.c, which puts the submission's variables back as they were first;
- what stands before some functions of the C library (acts.c), to note what isolation refuses.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

from pycparser import c_ast, c_generator, c_parser  # type: ignore[import-untyped]

from grader.build.records import BindError, Binding, Function, Parameter
from grader.sandbox import surroundings

SHIM = Path(__file__).with_name("shim")
PARTS = ("watch.c", "acts.c", "paint.c", "renew.c")
HEADER = "exercises.h"  # the map: it includes every other header of the core
PREPROCESS_SECONDS = 20

# Types of the system headers that our own may use; cffi knows them by name.
SYSTEM_TYPES = ("uint8_t", "uint32_t", "int32_t", "uint64_t", "int64_t", "size_t", "bool", "FILE")
# What only compilers understand, and declarations do without.
IGNORED_WORDS = ("__extension__", "__restrict", "__inline", "__attribute__(x)")

_LINEMARKER = re.compile(r'#(?:line)? \d+ "([^"]*)"')
_DEFINE = re.compile(r"#define (\w+) (.+)")
_EXPRESSION = re.compile(r"[\w.()+\-*/%<>|&^~ ]+")
_IDENTIFIER = re.compile(r"(?<![\w.])[A-Za-z_]\w*")


def derive(folder: Path, defines: Sequence[str], compiler: Sequence[str]) -> tuple[Binding, str]:
    """Return the binding of the headers in `folder` and the text of the shim.

    `defines` are flags of the form "-DWIDTH=320". Raises BindError.
    """
    declared, own_macros = _own_lines(_preprocess(folder, defines, compiler))
    macros = dict(flag.removeprefix("-D").split("=", 1) for flag in defines) | own_macros
    prelude = "".join(f"typedef int {name};\n" for name in SYSTEM_TYPES)
    try:
        tree = c_parser.CParser().parse(prelude + _drop_bodies(declared), HEADER)
    except c_parser.ParseError as error:
        raise BindError(f"{folder / HEADER}: not understood: {error}") from error
    return _Declarations(tree.ext[len(SYSTEM_TYPES) :], macros).binding()


def _preprocess(folder: Path, defines: Sequence[str], compiler: Sequence[str]) -> str:
    command = [*compiler, "-E", "-dD", "-std=gnu11", *defines]
    command += [f"-D{word}=" for word in IGNORED_WORDS] + [HEADER]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            env=surroundings.of_a_question(),
            timeout=PREPROCESS_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BindError(f"{folder / HEADER}: cannot be preprocessed: {error}") from error
    if done.returncode != 0:
        raise BindError(f"{folder / HEADER}: cannot be preprocessed: {done.stderr.strip()[:500]}")
    return done.stdout


def _own_lines(text: str) -> tuple[str, dict[str, str]]:
    """Return the code and the `#define`s of our own headers; the system's have absolute paths."""
    code: list[str] = []
    macros: dict[str, str] = {}
    own = False
    for line in text.splitlines():
        marker = _LINEMARKER.match(line)
        if marker:
            own = not marker[1].startswith(("/", "<"))
        elif own and (define := _DEFINE.fullmatch(line)):
            macros[define[1]] = define[2]
        elif own and not line.startswith("#"):
            code.append(line)
    return "\n".join(code), macros


def _drop_bodies(code: str) -> str:
    """Replace the body of each function by a semicolon.

    A brace opens a body when a closing parenthesis stands before it at the outermost level.
    """
    kept: list[str] = []
    depth = 0
    body = False
    last = ""
    for token in re.findall(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|[{}]|[^{}"\']+', code):
        if token == "{":
            body = body or (depth == 0 and last.rstrip().endswith(")"))
            depth += 1
        if not body:
            kept.append(token)
        if token == "}":
            depth -= 1
            if body and depth == 0:
                kept.append(";")
                body = False
        last = token
    return "".join(kept)


class _Declarations:
    """What the headers declare, sorted: the walk over pycparser's tree."""

    def __init__(self, nodes: Sequence[c_ast.Node], macros: dict[str, str]) -> None:
        self._print = c_generator.CGenerator()
        self._cdef: list[str] = []
        self._wrappers: list[str] = []
        self._functions: dict[str, Function] = {}
        self._variables: dict[str, str] = {}
        self._structs: dict[str, tuple[str, ...]] = {}
        self._unions: set[str] = set()
        self._enumerators: list[str] = []
        for node in nodes:
            self._add(node)
        self._constants = (*_arithmetic(macros, self._enumerators), *self._enumerators)

    def binding(self) -> tuple[Binding, str]:
        binding = Binding(
            cdef="\n".join([*self._cdef, *_table_sizes(self._structs, self._constants)]),
            functions=self._functions,
            variables=self._variables,
            structs=self._structs,
            constants=self._constants,
        )
        return binding, _shim(self._wrappers, binding)

    def _add(self, node: c_ast.Node) -> None:
        for enum in _enums(node):
            self._enumerators += [each.name for each in enum.values.enumerators]
        if isinstance(node, c_ast.Decl) and isinstance(node.type, c_ast.FuncDecl):
            self._add_function(node)
            return
        text = self._print.visit(node)
        if isinstance(node, c_ast.Typedef):
            self._add_struct(node)
        elif isinstance(node, c_ast.Decl) and "extern" in node.storage:
            self._variables[node.name] = self._ctype(node.type)
        self._cdef.append(text + ";")

    def _add_struct(self, node: c_ast.Typedef) -> None:
        inner = getattr(node.type, "type", None)
        if not isinstance(inner, c_ast.Struct) or not inner.decls:
            return
        self._structs[node.name] = tuple(_field_names(inner))
        if any(each.name is None for each in inner.decls):
            self._unions.add(node.name)

    def _add_function(self, node: c_ast.Decl) -> None:
        declared = list(node.type.args.params) if node.type.args else []
        result = self._ctype(node.type.type)
        result = "" if result == "void" else result
        parameters = tuple(
            Parameter(each.name or f"p{k}", self._ctype(each.type), self._pointee(each.type))
            for k, each in enumerate(declared)
            if self._ctype(each.type) != "void"
        )
        by_address = tuple(each.name for each in parameters if each.ctype in self._unions)
        boxed = result in self._unions
        symbol = f"mrt_call_{node.name}"
        function = Function(node.name, symbol, result, parameters, boxed, by_address)
        self._functions[node.name] = function
        prototype, body = _wrapper(function)
        self._cdef.append(prototype + ";")
        self._wrappers.append(f"{prototype};\n{prototype} {{ mrt_paint(); {body} }}")
        if not boxed and not by_address and "inline" not in node.funcspec:
            # Whether the library has it: a wrapper would find out when it is called.
            self._cdef.append(self._print.visit(node) + ";")

    def _ctype(self, node: c_ast.Node) -> str:
        """Return the type alone, as C writes it without a name: "const ray *", "vec3 [3]"."""
        return str(self._print._generate_type(node, emit_declname=False)).strip()

    def _pointee(self, node: c_ast.Node) -> str:
        if isinstance(node, (c_ast.PtrDecl, c_ast.ArrayDecl)):
            return self._ctype(node.type).replace("const ", "")
        return ""


def _enums(node: c_ast.Node) -> Iterator[c_ast.Enum]:
    inner = getattr(node.type, "type", node.type)
    for each in {id(node.type): node.type, id(inner): inner}.values():
        if isinstance(each, c_ast.Enum) and each.values:
            yield each


def _field_names(struct: c_ast.Struct | c_ast.Union) -> Iterator[str]:
    """Names of the fields, those of anonymous structs and unions too, as C and cffi see them."""
    for each in struct.decls:
        if each.name is not None:
            yield each.name
        else:
            yield from _field_names(each.type)


def _arithmetic(macros: dict[str, str], known: Sequence[str]) -> list[str]:
    """Return the macros that are numbers: made of numbers, operators and other such names."""
    numbers: list[str] = []
    for name, text in macros.items():
        words = _IDENTIFIER.findall(text)
        if _EXPRESSION.fullmatch(text) and all(word in numbers or word in known for word in words):
            numbers.append(name)
    return numbers


def _wrapper(function: Function) -> tuple[str, str]:
    """Return the prototype and the body of a wrapper."""
    parameters, arguments = [], []
    if function.boxed:
        parameters.append(f"{function.result} *mrt_result")
    for each in function.parameters:
        if each.name in function.by_address:
            parameters.append(f"const {each.ctype} *{each.name}")
            arguments.append(f"*{each.name}")
        else:
            parameters.append(f"{each.ctype} {each.name}")
            arguments.append(each.name)
    call = f"{function.name}({', '.join(arguments)});"
    result = "void" if function.boxed or not function.result else function.result
    before = "*mrt_result = " if function.boxed else "return " if function.result else ""
    return f"{result} {function.symbol}({', '.join(parameters) or 'void'})", before + call


def _table_sizes(structs: dict[str, tuple[str, ...]], constants: Sequence[str]) -> list[str]:
    entries = sum(1 + len(fields) for fields in structs.values())
    return [
        f"extern const size_t mrt_layout[{entries}];",
        f"extern const double mrt_constants[{len(constants)}];",
        "void mrt_watch(void *memory, int sanitized);",
        "bool mrt_keep(void);",
        "void mrt_renew(void);",
    ]


def _shim(wrappers: Sequence[str], binding: Binding) -> str:
    sizes: list[str] = []
    for struct, fields in binding.structs.items():
        sizes.append(f"sizeof({struct})")
        sizes += [f"offsetof({struct}, {name})" for name in fields]
    values = [f"(double)({name})" for name in binding.constants]
    return "\n".join(
        [
            "/* Generated by grader/build/headers.py: what the grader needs of the library. */",
            *((SHIM / name).read_text(encoding="utf-8") for name in PARTS),
            f'#include "{HEADER}"',
            "#include <stddef.h>",
            *_table_sizes(binding.structs, binding.constants),
            f"const size_t mrt_layout[] = {{ {', '.join(sizes)} }};",
            f"const double mrt_constants[] = {{ {', '.join(values)} }};",
            *wrappers,
            "",
        ]
    )
