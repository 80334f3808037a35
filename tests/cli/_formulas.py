"""Printed formulas as expressions of sympy."""

import json
import re

import sympy
from _program import run

TOKEN = re.compile(r"\s*(\d+\.?\d*(?:e[-+]?\d+)?|[A-Za-z_]\w*|[-+*/^()])")


class Names(dict):
    """Symbols by name, made when they are asked for; `beta` and `S` are plain symbols, too."""

    def __missing__(self, name):
        self[name] = sympy.Symbol(name)
        return self[name]


NAMES = Names()


def parse(text):
    """Adjacent factors are multiplied, products and quotients associate to the left, as docs/equations.md prints them."""
    words, at = [], 0
    while at < len(text.rstrip()):
        match = TOKEN.match(text, at)
        assert match, text[at:]
        word, at = match.group(1), match.end()
        before = words[-1] if words else "("
        is_call = word == "(" and before in ("sin", "cos", "sqrt")
        if before not in "+-*/^(" and word not in "+-*/^)" and not is_call:
            words.append("*")
        words.append(word)
    for k, word in enumerate(words):
        if word == "^":
            words[k] = "**"
        elif re.fullmatch(r"\d+", word):
            words[k] = f"Integer({word})"
    functions = {"sin": sympy.sin, "cos": sympy.cos, "sqrt": sympy.sqrt, "Integer": sympy.Integer}
    return eval(" ".join(words), {"__builtins__": {}}, _Scope(functions))  # noqa: S307 (the program's own output)


class _Scope(dict):
    def __missing__(self, name):
        return NAMES[name]


def equations(spec, *arguments):
    """What `balance equations` prints, by section: {section: {name: expression}}; conditions are a list under ''."""
    done = run("equations", spec, "--json", *arguments)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    found = {}
    for section in answer["sections"]:
        formulas = found.setdefault(section["section"], {"": []})
        for one in section["formulas"]:
            if one["name"]:
                formulas[one["name"]] = parse(one["formula"])
            else:
                formulas[""].append(parse(one["formula"]))
        formulas.update({name: sympy.Integer(0) for name in section["zero"]})
    return found, answer
