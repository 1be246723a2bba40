# SPDX-License-Identifier: Apache-2.0
"""Compiles the shader interface by itself and with its examples, by gcc and clang, in each language that it promises, with
pedantic warnings as errors.

    compilers.py SOURCE-FOLDER BUILD'S-C-COMPILER BUILD'S-C++-COMPILER

Says what it had no compiler for. Exit status 1: something does not compile as it should.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

FLAGS = ["-fsyntax-only", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror"]
HEADER = "#include <patina/shader.h>\n"
SDK = "#include <patina/sdk.h>\n"
NEEDS_20 = "patina/sdk.h needs C++20"


def main(source, cc, cxx):
    example = (source / "shaderapi/examples/dots.c").read_text(encoding="utf-8")
    sdk = sorted((source / "shaderapi/patina/sdk").glob("*.h"))
    shaders = [(f"shaders/{name}.cpp", (source / f"shaders/{name}.cpp").read_text(encoding="utf-8"))
               for name in ("matte", "marble", "texturedmatte", "envlight", "dirt")]
    # (what, language, text, the error that is expected)
    c = [("shader.h", HEADER, None), ("dots.c", example, None)]
    cases = [(f"{what} as {std}", std, text, error) for std in ("c11", "c17") for what, text, error in c]
    cases += [(f"shader.h as {std}", std, HEADER + "int main() { return int(sizeof(PatinaShader)) * 0; }\n", None)
              for std in ("c++17", "c++20")]
    cases += [("sdk.h as c++17", "c++17", SDK, NEEDS_20), ("sdk.h as c++20", "c++20", SDK, None)]
    cases += [(f"sdk/{header.name} as c++20", "c++20", f"#include <patina/sdk/{header.name}>\n", None) for header in sdk]
    cases += [(f"{name} as c++20", "c++20", text, None) for name, text in shaders]

    failed = 0
    for names, c_compiler, cxx_compiler in (("the build's", cc, cxx), ("gcc", "gcc", "g++"), ("clang", "clang", "clang++")):
        c_compiler, cxx_compiler = shutil.which(c_compiler), shutil.which(cxx_compiler)
        if not c_compiler or not cxx_compiler:
            print(f"SKIPPED: there is no {names}")
            continue
        if names != "the build's" and pathlib.Path(cc).resolve() == pathlib.Path(c_compiler).resolve():
            continue
        with tempfile.TemporaryDirectory() as folder:
            for what, std, text, error in cases:
                language = "c++" if "++" in std else "c"
                compiler = cxx_compiler if language == "c++" else c_compiler
                file = pathlib.Path(folder, "unit.cpp" if language == "c++" else "unit.c")
                file.write_text(text, encoding="utf-8")
                command = [compiler, f"-std={std}", *FLAGS, "-I", str(source / "shaderapi"), "-I", str(source / "shaders"), str(file)]
                result = subprocess.run(command, capture_output=True, text=True)
                good = result.returncode == 0 if error is None else result.returncode != 0 and error in result.stderr
                print(f"{pathlib.Path(compiler).name}: {what}{'' if error is None else ' is refused'}: "
                      f"{'good' if good else 'WRONG'}")
                if not good:
                    print(result.stderr)
                    failed += 1
    print(f"{failed} wrong")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).absolute(), sys.argv[2], sys.argv[3]))
