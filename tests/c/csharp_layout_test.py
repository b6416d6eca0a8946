"""The structs, enums and imports of the C# example are those of the C header: sizes, offsets and types of all fields.

    csharp_layout_test.py proxima.h Proxima.cs"""
import re
import sys
from pathlib import Path

header, csharp = (Path(name).read_text() for name in sys.argv[1:])
wrong = []

SIZES = {"f64": 8, "i32": 4, "u32": 4, "i64": 8, "u64": 8, "u8": 1, "pointer": 8}
C_TYPES = {"double": "f64", "int32_t": "i32", "uint32_t": "u32", "uint64_t": "u64", "size_t": "u64", "uint8_t": "u8"}
CSHARP_TYPES = {"double": "f64", "int": "i32", "uint": "u32", "long": "i64", "ulong": "u64", "byte": "u8", "UIntPtr": "u64",
                "IntPtr": "pointer", "Handle": "pointer"}
ENUMS = {"Additions": "proxima_additions", "FeatureKind": "proxima_feature_kind", "Faces": "proxima_faces"}
INSIDE_OTHERS = {"Contact": "proxima_contact"}  # no function takes them by themselves


def layout(fields):
    """Offset and type of each number, and the size, as compilers lay structs out: each number at a multiple of its size. A
    nested struct begins where its own alignment says."""
    numbers, end, alignment = [], 0, 1
    for kind in fields:
        inner, size, align = kind if isinstance(kind, tuple) else ([(0, kind)], SIZES[kind], SIZES[kind])
        begin = -(-end // align) * align
        numbers += [(begin + offset, number) for offset, number in inner]
        end, alignment = begin + size, max(alignment, align)
    return numbers, -(-end // alignment) * alignment, alignment


def without_comments(text):
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)


# ---- the header
header = without_comments(header)
c_structs, c_names = {}, {}
for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\}", header, flags=re.DOTALL):
    fields, names = [], []
    for declaration in body.split(";")[:-1]:
        kind, star, field, count = re.fullmatch(r"\s*(\w+)( ?\*)? ?(\w+)(?:\[(\d+)\])?\s*", declaration).groups()
        fields += [c_structs.get(kind) or ("pointer" if star else C_TYPES[kind])] * int(count or 1)
        names.append(field)
    c_structs[name], c_names[name] = layout(fields), names
c_enums = {name: {key: int(value) for key, value in re.findall(r"(\w+) = (\d+)", body)}
           for name, body in re.findall(r"typedef enum (\w+) \{(.*?)\}", header, flags=re.DOTALL)}
c_functions = {name: (kind, [] if parameters == "void" else [p.strip() for p in parameters.split(",")])
               for kind, name, parameters in re.findall(r"PROXIMA_C_API ([^;(]*?)(\w+)\(([^)]*)\);", header)}


def c_parameter(text):
    """What a parameter passes, and what a pointer points to, where that is known."""
    kind, name, count = re.fullmatch(r"(?:const )?(\w+\*{0,2})\s*(\w+)(?:\[(\d+)\])?", re.sub(r"\s+\*", "*", text)).groups()
    target = kind.rstrip("*")
    if count:
        return "pointer", layout([C_TYPES[target]] * int(count))
    if kind.endswith("*"):
        known = c_structs.get(target) or (target in C_TYPES and layout([C_TYPES[target]]))
        return "pointer", known if kind.count("*") == 1 else None
    return ("i32" if kind in c_enums else C_TYPES[kind]), None


# ---- the C# file
csharp = without_comments(csharp)
enums = {name: (base or "int", dict((key, int(value)) for key, value in re.findall(r"(\w+) = (\d+)", body)))
         for name, base, body in re.findall(r"enum (\w+)(?: : (\w+))? \{(.*?)\}", csharp, flags=re.DOTALL)}


def body_at(position):
    """What is between the braces that open at or behind this position, without what is in braces there."""
    begin = csharp.index("{", position)
    depth, kept = 0, ""
    for letter in csharp[begin:]:
        depth += (letter == "{") - (letter == "}")
        if depth == 0:
            return kept
        if depth == 1:
            kept += letter if letter not in "{}" else ";"
    raise ValueError("a brace is not closed")


structs = {}
for match in re.finditer(r"\[StructLayout\(([^\]]*)\)\]\s*public struct (\w+)", csharp):
    if match.group(1) != "LayoutKind.Sequential":
        sys.exit(f"{match.group(2)}: its layout is {match.group(1)}, which this test does not know")
    structs[match.group(2)] = body_at(match.end())
layouts = {}


def csharp_type(name):
    if name in structs:
        return layout_of(name)
    name = enums[name][0] if name in enums else name
    if name not in CSHARP_TYPES:
        sys.exit(f"{name}: a type of C# that this test does not know: name its size in CSHARP_TYPES")
    return CSHARP_TYPES[name]


def layout_of(name):
    if name not in layouts:
        fields = []
        for kind, names in re.findall(r"[;{]\s*public (\w+) (\w+(?:, \w+)*)(?=;)", structs[name]):
            fields += [csharp_type(kind)] * len(names.split(","))
        layouts[name] = layout(fields)
    return layouts[name]


def compare(name, own, c_name, other):
    if own != other:
        first = next((f"; first at byte {a[0]}: {a[1]} for {b[1]} at byte {b[0]}" for a, b in zip(own[0], other[0]) if a != b), "")
        wrong.append(f"{name} has {own[1]} bytes, {len(own[0])} numbers; {c_name} {other[1]} bytes, {len(other[0])} numbers{first}")


# ---- imports: each exists in C, with the same parameters
compared = set()
imports = re.findall(r"\[DllImport\(([^)]*)\)\]\s*(?:private|internal|public) static extern (\w+) (\w+)\(([^)]*)\);", csharp)
if len(imports) != csharp.count("[DllImport("):
    wrong.append(f"only {len(imports)} of {csharp.count('[DllImport(')} imports were understood")
for how, kind, name, parameters in imports:
    if name not in c_functions:
        wrong.append(f"{name}: the header has no such function")
        continue
    c_kind, c_parameters = c_functions[name]
    expected = {"proxima_status": "int", "void": "void", "const char*": "IntPtr"}.get(c_kind.strip())
    if kind != expected:
        wrong.append(f"{name} returns {kind}, in C {c_kind.strip()}")
    if "CallingConvention.Cdecl" not in how:
        wrong.append(f"{name}: not CallingConvention.Cdecl")
    parameters = [p.strip() for p in parameters.split(",")] if parameters.strip() else []
    if len(parameters) != len(c_parameters):
        wrong.append(f"{name} takes {len(parameters)} parameters, in C {len(c_parameters)}")
        continue
    for parameter, c_text in zip(parameters, c_parameters):
        passing, type_name, array = re.fullmatch(r"(?:\[Out\] )?(ref |out )?(\w+)(\[\])? \w+", parameter).groups()
        passed, target = c_parameter(c_text)
        own = "pointer" if passing or array else csharp_type(type_name)
        if own != passed:
            wrong.append(f"{name}: {parameter} for {c_text}")
        elif passing and target:
            own = layout_of(type_name) if type_name in structs else layout([csharp_type(type_name)])
            compare(f"{name}: {type_name}", own, c_text, target)
            compared.add(type_name)
        elif array and target and type_name not in structs and type_name != "byte" and layout([csharp_type(type_name)]) != target:
            wrong.append(f"{name}: {parameter} for {c_text}")

# ---- structs that are only inside of others, and enums
for name, c_name in INSIDE_OTHERS.items():
    compare(name, layout_of(name), c_name, c_structs[c_name])
    compared.add(name)
for name in sorted(set(structs) - compared):
    wrong.append(f"{name}: no import takes it: name its struct of C in this test")
for name in sorted(set(enums) - set(ENUMS)):
    wrong.append(f"{name}: name its enum of C in this test")
for name, c_name in ENUMS.items():
    own = {re.sub(r"(?<!^)(?=[A-Z])", "_", key).upper(): value for key, value in enums[name][1].items()}
    if name == "Additions" and own.pop("NONE", 0) != 0:
        wrong.append("Additions.None is not 0")
    other = {key.removeprefix("PROXIMA_"): value for key, value in c_enums[c_name].items()}
    if own != other:
        wrong.append(f"{name} has {own}, {c_name} {other}")

print(f"{len(structs)} structs, {len(enums)} enums, {len(imports)} imports; Tick has {layout_of('Tick')[1]} bytes")
if len(structs) < 11 or len(imports) < 25:
    wrong.append("there are fewer structs or imports than there were: is the file understood?")
if wrong:
    sys.exit("\n".join(wrong))
