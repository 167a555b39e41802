#!/usr/bin/env python3
"""Writes the types of the answers, `crates/mlr-py/python/mlr/answers.py`, from the JSON Schemas in `docs/schemas`.

    python tools/python/answers.py [--check]
"""

import json
import re
import sys
import textwrap
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = ROOT / "docs" / "schemas"
TYPES = ROOT / "crates" / "mlr-py" / "python" / "mlr" / "answers.py"
ANSWERS = ["identification", "explanation", "detection", "simulation", "calibration"]
PLAIN = {"string": "str", "integer": "int", "number": "float", "boolean": "bool", "null": "None"}

HEAD = '''"""The types of the answers: written by tools/python/answers.py from docs/schemas, not by hand.

Numbers are in the units that their names end in.
"""

from typing import Literal, TypeAlias, TypedDict

'''


def sentence(schema):
    """The first sentence of the description, without the links of Rust's documentation."""
    text = " ".join(schema.get("description", "").split("\n\n")[0].split())
    text = re.split(r"(?<=\.) (?=[A-Z])", text)[0]
    return re.sub(r"\[`([^`]*)`\](\([^)]*\))?", r"`\1`", text)


def name_of(reference):
    return reference.rsplit("/", 1)[1]


def type_of(schema):
    """The Python type of what a schema describes."""
    if "$ref" in schema:
        return name_of(schema["$ref"])
    if "const" in schema:
        return f"Literal[{json.dumps(schema['const'])}]"
    for either in ("oneOf", "anyOf"):
        if either in schema:
            kinds = [type_of(one) for one in schema[either]]
            if all(kind.startswith("Literal[") for kind in kinds):
                return f"Literal[{', '.join(kind[8:-1] for kind in kinds)}]"
            return " | ".join(dict.fromkeys(kinds))
    if "enum" in schema:
        return f"Literal[{', '.join(json.dumps(one) for one in schema['enum'])}]"
    kinds = schema["type"]
    if isinstance(kinds, list):
        return " | ".join(type_of({**schema, "type": kind}) for kind in kinds)
    if kinds == "array":
        return f"list[{type_of(schema['items'])}]"
    if kinds == "object":
        return f"dict[str, {type_of(schema['additionalProperties'])}]"
    return PLAIN[kinds]


def comment(text, indent):
    return textwrap.indent("\n".join(textwrap.wrap(text, 96 - len(indent))), indent + "# ") + "\n" if text else ""


def typed_dict(name, schema):
    """A class for an object; what need not be there is in its second half."""
    properties, required = schema["properties"], set(schema.get("required", schema["properties"]))
    needed = {key: one for key, one in properties.items() if key in required}
    others = {key: one for key, one in properties.items() if key not in required}

    def body(keys):
        return "".join(comment(sentence(one), "    ") + f"    {key}: {type_of(one)}\n" for key, one in keys.items())

    head = f'    """{sentence(schema)}"""\n\n' if sentence(schema) else ""
    if not others:
        return f"class {name}(TypedDict):\n{head}{body(needed)}"
    return (
        f"class _{name}(TypedDict):\n{body(needed)}\n\n"
        f"class {name}(_{name}, total=False):\n{head}{body(others)}"
    )


def references(schema):
    """All that a schema refers to; its own definitions are not it."""
    if isinstance(schema, dict):
        for key, one in schema.items():
            if key == "$ref":
                yield one
            elif key != "$defs":
                yield from references(one)
    elif isinstance(schema, list):
        for one in schema:
            yield from references(one)


def types():
    """The text of the module."""
    parts, answers = {}, {}
    for answer in ANSWERS:
        schema = json.loads((SCHEMAS / f"{answer}.schema.json").read_text())
        for name, part in schema.get("$defs", {}).items():
            if parts.setdefault(name, part) != part:
                raise SystemExit(f"{name}: differs between the schemas of several answers")
        answers[answer.capitalize()] = schema
    text = HEAD
    for name, part in sorted(parts.items()):
        if "properties" not in part:
            text += f"{comment(sentence(part), '')}{name}: TypeAlias = {type_of(part)}\n"
    objects = {name: part for name, part in parts.items() if "properties" in part} | answers
    # What others refer to comes before them.
    needs = {
        name: sorted({one for one in map(name_of, references(part)) if one in objects})
        for name, part in sorted(objects.items())
    }
    for name in TopologicalSorter(needs).static_order():
        text += "\n\n" + typed_dict(name, objects[name])
    return text


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        if TYPES.read_text() != types():
            raise SystemExit(f"{TYPES}: the schemas have changed; tools/python/answers.py writes it anew")
    else:
        TYPES.write_text(types())
