"""Which mutants say something about a formula, by the place where they stand."""

import ast


def passed_over(source):
    """Places of a module whose mutants are not run.

    Signatures, decorators, annotations, and what is raised are no formulas, and neither are the stars of
    arguments; defaults of arguments count. Numbers that are given a name or a default of a field,
    ``CUT = 2.15``, are settings: a test could only repeat them. Numbers within an expression count.

    Returns
    -------
    list of ((line, column), (line, column))
        Begin and end; lines count from 1, columns from 0.
    """
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            found += _signature(node)
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found += map(_span, node.decorator_list)
        if isinstance(node, ast.AnnAssign):
            found.append(_span(node.annotation))
        if isinstance(node, ast.Raise):
            found.append(_span(node))
        if isinstance(node, ast.Starred) or (isinstance(node, ast.keyword) and node.arg is None):
            found.append((_span(node)[0], _span(node.value)[0]))
        if isinstance(node, ast.Module | ast.ClassDef):
            settings = (each for each in node.body if isinstance(each, ast.Assign | ast.AnnAssign))
            found += [_span(each.value) for each in settings if _is_number(each.value)]
    return found


def _span(node):
    return (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)


def _signature(function):
    """From ``def`` to the first statement, but for the defaults."""
    defaults = [each for each in (*function.args.defaults, *function.args.kw_defaults) if each is not None]
    begin, spans = _span(function)[0], []
    for first, last in sorted(map(_span, defaults)):
        spans.append((begin, first))
        begin = last
    return [*spans, (begin, _span(function.body[0])[0])]


def _is_number(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def lies_in(start, places):
    """Whether a position (line, column) lies in one of some places."""
    return any(first <= start < last for first, last in places)
