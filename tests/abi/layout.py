# SPDX-License-Identifier: Apache-2.0
"""Compares shaderapi/patina/shader.h with the stored table of what plugins in the field rely on.

    layout.py HEADER C-COMPILER TABLE

Exit status 0: they agree. 1: they do not; what has changed is named, and rows that may be appended are printed.

A row of the table is `minor kind name value...`, of an LP64 machine:
    0 size   PatinaTraits 64                            bytes of the struct at that minor version
    0 member PatinaTraits.flags 40 8 uint64_t flags     offset, bytes, declaration
    0 value  PATINA_TRAIT_OPAQUE 1                      of an enumerator or of a macro
Rows are only ever appended, with the minor version that they came with. Those of versions that have been given to plugin
writers are sealed: SEALED has their digests.
"""
import hashlib
import pathlib
import re
import subprocess
import sys
import tempfile

SEALED = {
    0: "7c1d3a5a1b71133e9067e7bd10327b8ba629319d067088bec369c538d9d098d3",
    1: "3babc1eb7881d935b99d5c21ff547e22fbf2b78c1ca63017bd91d6318628d322",
    2: "268fd294556ddbf9312fed4585f4983d330aee0f5469175e189d3bdd6ec0d67d",
    3: "399915de09962e266a11a4f7ce414c73ac1a23088e5db31d4c9010144653b8a3",
}
# Structs that come in arrays with a stride, and may grow without saying their size.
STRIDED = {"PatinaValue"}


def declarators(declaration):
    """The names declared by one member declaration, each with a declaration of its own."""
    declaration = " ".join(declaration.split())
    function = re.match(r".*?\(\s*\*\s*(\w+)\s*\)\s*\(", declaration)
    if function:  # what its arguments are called is nobody's business
        head, arguments = declaration[:function.end()], declaration[function.end():-1]
        types = [re.sub(r"\w+(?=(\[\w+\])*$)", "", argument).strip() for argument in arguments.split(",")]
        return [(function[1], head + ", ".join(types) + ")")]
    first, *others = declaration.split(",")
    base, pointer, name = re.fullmatch(r"(.*?[\w*]\s*?)(\**\s*)((?<=[\s*])\w+(?:\[\w+\])*)", first).groups()
    parts = [pointer + name] + [other.strip() for other in others]
    return [(re.search(r"\w+", part)[0], f"{base.strip()} {part.strip()}") for part in parts]


def declared(header):
    """Structs, each with its members (name, declaration), and the names of numbers and of texts."""
    text = re.sub(r"/\*.*?\*/", " ", header, flags=re.DOTALL)
    macros = re.findall(r"^#\s*define\s+(PATINA_\w+)[ \t]+(.+)$", text, re.MULTILINE)
    text = re.sub(r"^#.*(?:\\\n.*)*$", "", text, flags=re.MULTILINE)
    structs = {m[1]: [d for part in m[2].split(";") if part.strip() for d in declarators(part)]
               for m in re.finditer(r"typedef struct (\w+)\s*\{(.*?)\}\s*\1\s*;", text, re.DOTALL)}
    numbers = [name for m in re.finditer(r"enum\s*(?:\w+\s*)?\{(.*?)\}", text, re.DOTALL)
               for name in re.findall(r"\b(PATINA_\w+)\s*(?:=|,|$)", m[1].strip())]
    loose = set(re.findall(r"\bstruct (\w+)\s*\{", text)) - set(structs)
    if loose:
        sys.exit(f"layout.py: structs that it cannot read: {', '.join(sorted(loose))}")
    texts = [name for name, value in macros if value.startswith('"')]
    numbers += [name for name, value in macros if re.match(r"[-(\d]|UINT64_C", value) and name != "PATINA_ABI_MINOR"]
    return structs, numbers, texts


def rows_of(header, compiler):
    """(kind, name) -> value for all that the header declares, and the header's minor version."""
    structs, numbers, texts = declared(header.read_text(encoding="utf-8"))
    lines = ["#include <stddef.h>", "#include <stdio.h>", f'#include "{header}"', "int main(void) {"]
    for struct, members in structs.items():
        lines.append(f'printf("size {struct} %zu\\n", sizeof({struct}));')
        for name, text in members:
            size = f"sizeof((({struct} *)0)->{name})"
            lines.append(f'printf("member {struct}.{name} %zu %zu {text}\\n", offsetof({struct}, {name}), {size});')
    lines += [f'printf("value {name} %.9g\\n", (double){name});' for name in numbers]
    lines += [f'printf("value {name} \\"%s\\"\\n", {name});' for name in texts]
    lines += ['printf("minor version %u\\n", PATINA_ABI_MINOR);', "return 0; }"]
    with tempfile.TemporaryDirectory() as folder:
        source, program = pathlib.Path(folder, "layout.c"), pathlib.Path(folder, "layout")
        source.write_text("\n".join(lines), encoding="utf-8")
        subprocess.run([compiler, "-std=c11", "-o", program, source], check=True)
        output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    found = {}
    for line in output.splitlines():
        kind, name, value = line.split(" ", 2)
        found[kind, name] = value
    return found, int(found.pop(("minor", "version")))


def main(header, compiler, table):
    found, minor = rows_of(header, compiler)
    structs = {name for kind, name in found if kind == "size"}
    stored, sizes, digests, faults = {}, {}, {}, []
    for number, line in enumerate(table.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        since, kind, name, value = line.split(" ", 3)
        digests.setdefault(int(since), hashlib.sha256()).update((line + "\n").encode())
        if int(since) > minor:
            faults.append(f"line {number} is of minor version {since}, the header of {minor}")
        if kind == "size":
            sizes.setdefault(name, []).append((int(since), int(value)))
            if found.get((kind, name)) == value:
                stored[kind, name] = value
            continue
        if (kind, name) in stored:
            faults.append(f"line {number}: {name} is there twice")
        stored[kind, name] = value
        if found.get((kind, name)) != value:
            faults.append(f"line {number}: {kind} {name} was {value}, is {found.get((kind, name), 'gone')}")

    for name, history in sizes.items():
        versions, bytes_ = zip(*history)
        now = int(found.get(("size", name), 0))
        if list(versions) != sorted(set(versions)) or list(bytes_) != sorted(set(bytes_)):
            faults.append(f"{name}: its sizes do not grow with the minor version: {history}")
        if now < bytes_[-1]:
            faults.append(f"{name} has shrunk from {bytes_[-1]} to {now} bytes")
        first = min((int(value.split()[0]), key[1]) for key, value in found.items()
                    if key[0] == "member" and key[1].startswith(name + "."))[1] if name in structs else ""
        if now > bytes_[0] and name not in STRIDED and first != name + ".struct_size":
            faults.append(f"{name} has grown, and nobody can tell by a struct_size or a stride")
    for since, digest in digests.items():
        if digest.hexdigest() != SEALED.get(since, digest.hexdigest()):
            faults.append(f"the table's rows of minor version {since} are sealed, and have been changed: {digest.hexdigest()}")

    new = [key for key in found if key not in stored]
    for kind, name in new:
        history = sizes.get(name.split(".")[0])
        if kind == "member" and history and int(found[kind, name].split()[0]) < history[-1][1]:
            faults.append(f"{name} is new, and lies within what {name.split('.')[0]} was: new members go to the end")
    if new:
        if minor in SEALED:
            faults.append(f"there are new declarations, and minor version {minor} is sealed: PATINA_ABI_MINOR goes up first")
        faults.append(f"{table} lacks {len(new)} rows. If the change is meant, append:\n" +
                      "\n".join(f"{minor} {kind} {name} {found[kind, name]}" for kind, name in new))
    for fault in faults:
        print(fault)
    print(f"{len(found)} declarations, {len(stored)} rows in force, minor version {minor}, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).absolute(), sys.argv[2], pathlib.Path(sys.argv[3])))
