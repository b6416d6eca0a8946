"""What the public headers declare: functions, classes and their public members, by name."""
import re


def _without_comments(text):
    text = re.sub(r"//.*", "", text)
    text = re.sub(r'"(?:\\.|[^"\\])*"', '""', text)
    return "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))


def _statements(text):
    """(head, body) of each statement; body is None unless it has braces of its own."""
    head, depth, body = "", 0, ""
    for character in text:
        if depth:
            depth += (character == "{") - (character == "}")
            if depth:
                body += character
            else:
                yield head.strip(), body
                head, body = "", ""
        elif character == "{":
            depth = 1
        elif character == ";":
            if head.strip():
                yield head.strip(), None
            head = ""
        else:
            head += character


def _class_of(head):
    found = re.match(r"(?:template\s*<.*?>\s*)?(class|struct)\s+(\w+)", head)
    return found and (found[1], found[2])


def _function_of(head):
    """The name of the declared function; None for other declarations."""
    plain = re.sub(r"\[\[.*?\]\]", "", head)
    if re.match(r"\s*(?:template\b.*?\bconcept\b|class|struct|enum|using|static_assert|friend|namespace)", plain, re.DOTALL):
        return None
    found = re.match(r"[^=(]*?(operator\W+|~?\w+)\s*\(", plain)
    return found and found[1].strip()


def _members(kind, body):
    """Names of public members: functions and fields. Constructors and operators are left out."""
    body = re.sub(r"^\s*(public|private|protected):", r";@\1;", body, flags=re.MULTILINE)
    public = kind == "struct"
    names = set()
    for head, inner in _statements(body):
        if head.startswith("@"):
            public = head == "@public"
        elif public and not head.startswith(("friend", "static_assert", "using", "enum")) and not _class_of(head):
            function = _function_of(head)
            field = re.search(r"(\w+)(?:\s*=.*)?$", head, re.DOTALL)
            if function:
                names.add(function)
            elif field:
                names.add(field[1])
    return {name for name in names if name.isidentifier()}


def declarations(header):
    """(functions, {class: members}) of a header's namespace."""
    text = _without_comments(header.read_text())
    functions, classes = set(), {}
    for head, body in _statements(text):
        if re.fullmatch(r"namespace PROXIMA_EXPORT proxima", head):
            for inner, inner_body in _statements(body):
                declared = _class_of(inner)
                if declared and inner_body is not None:
                    members = _members(declared[0], inner_body) - {declared[1]}
                    classes[declared[1]] = members
                elif (name := _function_of(inner)) and not name.startswith("operator"):
                    functions.add(name)
    return functions, classes
