# SPDX-License-Identifier: Apache-2.0
"""Runs of patina for the programs of this folder: what they cost, what their statistics say, what their pictures hold."""
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))


def default_patina():
    return os.path.join(ROOT, "build/release/bin/patina")


def render(patina, rib, arguments=(), folder=None, timeout=None, check=True):
    """A process of its own in `folder` (that of the RIB, if none is given). Wall and CPU seconds and megabytes at most of the
    whole process, and its statistics; "ended" instead where `timeout` seconds were not enough."""
    with tempfile.NamedTemporaryFile(suffix=".json") as stats, tempfile.TemporaryFile("w+") as messages:
        command = [patina, "-q", *map(str, arguments), "--stats", stats.name, rib]
        # By a shell that stays: a process started from here would begin with this one's peak of memory as its own.
        start = time.monotonic()
        process = subprocess.Popen(["/bin/sh", "-c", '"$0" "$@"; exit $?', *command], stdout=messages, stderr=messages,
                                   cwd=folder or os.path.dirname(os.path.abspath(rib)), start_new_session=True)
        ended = False
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if timeout and time.monotonic() - start > timeout and not ended:
                os.killpg(process.pid, signal.SIGKILL)
                ended = True
            time.sleep(0.0005 if time.monotonic() - start < 2 else 0.02)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        cost = {"wall": wall, "cpu": usage.ru_utime + usage.ru_stime, "status": process.returncode}
        if ended:
            return {**cost, "ended": True, "MB": 0, "stats": {}}
        messages.seek(0)
        text = messages.read()
        if check and process.returncode != 0:
            raise SystemExit(f"{' '.join(command)}: status {process.returncode}\n{text}")
        stats.seek(0)
        data = stats.read()
        statistics = json.loads(data) if data else {}
        return {**cost, "MB": count(statistics, "Memory", "peak resident MB"), "messages": text, "stats": statistics}


def count(stats, *names):
    """A counter by its place in the tree; 0 where there is none."""
    for name in names:
        stats = stats.get(name, {}) if isinstance(stats, dict) else {}
    return stats if isinstance(stats, (int, float)) else 0


def shader_points(stats):
    """Points by entry point, over all shaders, and by shader and entry point."""
    by_entry, by_shader = {}, {}
    for shader, entries in stats.get("Shaders", {}).items():
        for entry, values in entries.items() if isinstance(entries, dict) else ():
            points = values.get("points", 0) if isinstance(values, dict) else 0
            if points:
                by_entry[entry] = by_entry.get(entry, 0) + points
                by_shader[f"{shader} {entry}"] = points
    return by_entry, by_shader


def picture(path):
    """Linear red, green and blue: height x width x 3."""
    import numpy
    import OpenImageIO
    pixels = OpenImageIO.ImageBuf(path).get_pixels(OpenImageIO.FLOAT)
    if pixels.size == 0:
        raise SystemExit(f"{path}: cannot be read")
    return numpy.asarray(pixels[:, :, :3], dtype=float)


def relative_error(x, reference):
    """relMSE, as patina-bench has it."""
    return float(((x - reference) ** 2 / (reference ** 2 + 0.01)).mean())


def machine(patina):
    """What the numbers were measured on."""
    version = subprocess.run([patina, "--version"], capture_output=True, text=True, check=True).stdout.strip().replace("\n", "; ")
    model = platform.machine()
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    with open("/proc/meminfo", encoding="utf-8") as file:
        memory = int(file.readline().split()[1]) / 1e6
    return {"build": version, "CPU": f"{model}, {os.cpu_count()} processors", "memory": f"{memory:.1f} GB",
            "load before": f"{os.getloadavg()[0]:.2f} (0 = idle; others' work makes wall times longer)",
            "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), "command": " ".join([os.path.basename(sys.argv[0]), *sys.argv[1:]])}


def save(data, path):
    """JSON, whole or not at all."""
    with open(path + ".part", "w", encoding="utf-8") as file:
        json.dump(data, file, indent=1)
    os.replace(path + ".part", path)
