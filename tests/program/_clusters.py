"""tools/farm on local clusters of Dask and Ray, of which workers are killed while they work: every job
ends, no result is written twice, and the sweep gathers the same bytes as without a cluster.

Needs PANTIN, PANTIN_ASSETS and the engines: python3 -m pip install distributed ray. Run by
`tools/nightly farm`.

  _clusters.py dask ray
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

PANTIN = os.environ["PANTIN"]
SCENE = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes/chain10.json"
FARM = pathlib.Path(__file__).parents[2] / "tools/farm"
SWEEP = [PANTIN, "sweep", SCENE, "--over", "/generators/chains/0/mass=0.05..0.2:12"]
RUN = ["--", "run", "--duration", "60", "--json"]


def status(pid):
    """The parent and the command of a process, or nothing where it has ended."""
    try:
        parent = int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
        return parent, pathlib.Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")
    except OSError:
        return None


def below(pid):
    """All processes that descend from one: their parents and commands by number."""
    every = {int(p.name): found for p in pathlib.Path("/proc").iterdir()
             if p.name.isdigit() and (found := status(p.name))}
    found, added = {pid: (0, "")}, True
    while added:
        new = {p: s for p, s in every.items() if s[0] in found and p not in found}
        found.update(new)
        added = bool(new)
    return found


def kill_worker(pid, killed):
    """Kills a worker of a cluster, that is the parent of a shell that runs a job."""
    for parent, command in below(pid).values():
        if command.startswith("/bin/sh") and "sweep --one" in command and parent not in (pid, *killed):
            os.kill(parent, signal.SIGKILL)
            return parent
    return None


def check(engine, folder):
    def sweep(out, *more):
        subprocess.run([*SWEEP, *more, "--out", out, *RUN], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        return (folder / out / "results.jsonl").read_bytes() if "--emit" not in more else b""

    def files():
        return {p.name: p.stat().st_ino for p in (folder / "farm/jobs").glob("*.json")}

    sweep("farm", "--emit", "jobs.txt")
    run = subprocess.Popen([sys.executable, "-B", FARM, "jobs.txt", "--engine", engine, "--workers", "2"],
                           cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, text=True)
    killed, end = [], time.monotonic() + 300
    while run.poll() is None and len(killed) < 2 and time.monotonic() < end:
        if (worker := kill_worker(run.pid, killed)) is not None:
            killed.append(worker)
        time.sleep(1)
    said, _ = run.communicate(timeout=600)
    if run.returncode or "12 of 12 lines done" not in said:
        return f"exit code {run.returncode}\n{said[-3000:]}"
    if len(killed) < 2:
        return f"only {len(killed)} workers could be killed while they worked"
    before = files()
    gathered = sweep("farm")
    if len(before) != 12 or files() != before:
        return f"{len(before)} results, expected 12 that the sweep leaves as they are"
    return "" if gathered == sweep("local", "--jobs", "1") else "found other bytes than without a cluster"


def main():
    failed = False
    for engine in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as folder:
            fault = check(engine, pathlib.Path(folder))
        print(f"{engine}: {fault or 'two workers killed, 12 jobs done, the same bytes'}", flush=True)
        failed = failed or bool(fault)
    return 1 if failed or not sys.argv[1:] else 0


if __name__ == "__main__":
    sys.exit(main())
