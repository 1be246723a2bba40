#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The table, the plots of growth and the pairs of features, one after the other, to one folder, of small pictures. What
is measured already is kept, so that it may be ended and begun again.

    all.py [-o production-results] [--patina build/release/bin/patina]
"""
import argparse
import os
import subprocess
import sys

from runs import default_patina

HERE = os.path.dirname(os.path.abspath(__file__))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default="production-results")
    parser.add_argument("--patina", default=default_patina())
    args = parser.parse_args()
    os.makedirs(args.output, exist_ok=True)
    status = 0
    for program, output in (("table.py", args.output), ("growth.py", args.output), ("skips.py", os.path.join(args.output, "skips.md"))):
        status |= subprocess.run([sys.executable, "-B", os.path.join(HERE, program), "-o", output, "--patina", args.patina], check=False).returncode
    raise SystemExit(1 if status else 0)


if __name__ == "__main__":
    main()
