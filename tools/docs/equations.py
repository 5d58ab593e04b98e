"""Turns the plain equations of docstrings into MathML, which browsers draw without a script or a font of ours.

``F = F_c tanh(v / v_s)`` becomes LaTeX by a few rules and then MathML by latex2mathml. Words stay words.
"""

import re
from html import escape

from latex2mathml.converter import convert

GREEK = "alpha beta gamma delta theta kappa lambda mu nu omega sigma tau phi rho".split()
FUNCTIONS = {"arctan": "arctan", "cos": "cos", "exp": "exp", "ln": "ln", "log": "log", "max": "max", "min": "min",
             "sgn": "sgn", "sign": "sgn", "sin": "sin", "sqrt": "sqrt", "tanh": "tanh", "atan": "arctan"}  # fmt: skip
SIGNS = {
    "<-": r"\leftarrow", "<=": r"\le", ">=": r"\ge", "-=": r"\mathrel{-}=", "+=": r"\mathrel{+}=", "*": r"\cdot",
    "{": r"\{", "}": r"\}", "#": r"\#", "%": r"\%",
}  # fmt: skip
_TOKEN = re.compile(r"``[^`]+``|<-|<=|>=|[-+]=|[A-Za-z]+[0-9]*|[0-9]+(?:\.[0-9]+)?|\s+|.", re.DOTALL)
_SYMBOL = re.compile(
    r"(?<![`\w/])(?:[A-Za-z]+_[A-Za-z0-9]+'?|d[a-z]/d[a-z]|(?:" + "|".join(GREEK) + r")(?:_[A-Za-z0-9]+)?)(?![\w`(])"
)


def lines_of(block: str) -> list[str]:
    """The equations of an indented block, one each; a number in brackets stays with its equation."""
    lines: list[str] = []
    for line in block.splitlines():
        parts = re.split(r",?\s{4,}(?![\s(]|for |else)", line.strip())
        lines += [part for part in parts if part]
    return lines


def block_html(block: str) -> str:
    """An indented block of equations as display MathML, each on a line that scrolls by itself where it is too long."""
    rows = "".join(f'<div class="equation">{mathml(line)}</div>' for line in lines_of(block))
    return f'<div class="equations">{rows}</div>'


def mathml(text: str) -> str:
    """MathML of one plain equation; the plain text is its alternative for readers without MathML."""
    return convert(latex(text)).replace("<math ", f'<math alttext="{escape(text, quote=True)}" ', 1)


def with_symbols(paragraph: str) -> str:
    """A paragraph of a docstring with its symbols (``F_c``, ``tau``) as inline MathML, code left as it is."""
    parts = re.split(r"(``?[^`]+``?)", paragraph)
    return "".join(
        part if part.startswith("`") else _SYMBOL.sub(lambda found: mathml(found.group()), _units(part))
        for part in parts
    ).replace("``", "`")


def paragraph_html(paragraph: str) -> str:
    """A paragraph of a docstring as HTML: Markdown treats MathML at the start of a line as a separate block."""
    text = with_symbols(escape(paragraph, quote=False))
    return "<p>" + re.sub("`([^`]+)`", r"<code>\1</code>", text) + "</p>"


def _units(text: str) -> str:
    return re.sub(r"\b(m|mm|s)\^([23])\b", lambda found: found[1] + {"2": "²", "3": "³"}[found[2]], text)


def latex(text: str) -> str:
    """LaTeX of one plain equation."""
    return _written(_TOKEN.findall(re.sub(r"\s{2,}", " ", text)))


def _written(tokens: list[str]) -> str:
    out, i = [], 0
    while i < len(tokens):
        token = tokens[i]
        if token in "_^" and i + 1 < len(tokens):
            inside, i = _argument(tokens, i + 1)
            out.append(f"{token}{{{_subscript(inside) if token == '_' else _written(inside)}}}")
            continue
        if token == "'":
            out.append(r"\text{′}")
            i += 1
            continue
        if token == "sqrt" and i + 1 < len(tokens) and tokens[i + 1] == "(":
            inside, i = _argument(tokens, i + 1)
            out.append(rf"\sqrt{{{_written(inside)}}}")
            continue
        out.append(_one(token, tokens[:i], tokens[i + 1 :]))
        i += 1
    return "".join(out)


def _argument(tokens: list[str], i: int) -> tuple[list[str], int]:
    """What a subscript, an exponent or a root applies to, without its brackets, and where the rest begins."""
    if tokens[i] == "-" and i + 1 < len(tokens):
        return tokens[i : i + 2], i + 2
    if re.fullmatch(r"\d+", tokens[i]) and i + 1 < len(tokens) and re.fullmatch("[a-z]", tokens[i + 1]):
        return tokens[i : i + 2], i + 2  # x_2r
    if tokens[i] not in "({":
        return [tokens[i]], i + 1
    depth = 0
    for end in range(i, len(tokens)):
        depth += (tokens[end] in "({") - (tokens[end] in ")}")
        if depth == 0:
            return tokens[i + 1 : end], end + 1
    return tokens[i + 1 :], len(tokens)


def _subscript(tokens: list[str]) -> str:
    word = "".join(tokens)
    return rf"\mathrm{{{word}}}" if word.isalpha() and len(word) > 1 else _written(tokens)


def _one(token: str, before: list[str], after: list[str]) -> str:
    if token.startswith("``"):
        return rf"\texttt{{{token.strip('`').replace('_', chr(92) + '_')}}}"
    if token.isspace() and before[-2:-1] != ["_"]:
        return r"\ " if _wordlike(before[-1:]) or _wordlike(after[:1]) else " "
    if token in GREEK:
        return rf"\{token} "
    if token in FUNCTIONS:
        return rf"\operatorname{{{FUNCTIONS[token]}}}"
    if re.fullmatch(r"d[A-Za-z]", token):
        return rf"\mathrm{{d}}{token[1]} "
    if _wordlike([token]) or (token == "a" and _wordlike(before[-2:-1]) and _wordlike(after[1:2])):
        return rf"\text{{{token}}}"
    return SIGNS.get(token, token)


def _wordlike(tokens: list[str]) -> bool:
    if not tokens:
        return False
    word = tokens[0]
    return bool(
        re.fullmatch(r"[A-Za-z]{2,}", word)
        and word not in GREEK
        and word not in FUNCTIONS
        and not re.fullmatch(r"d[A-Za-z]", word)
    )
