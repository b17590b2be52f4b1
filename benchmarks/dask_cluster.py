"""A benchmark on a Dask cluster, one of whose workers is killed in the middle: are its results the local ones?

A scheduler and its workers are started as processes of this machine, as `dask scheduler` and `dask worker` would.
"""

import argparse
import contextlib
import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from springopt.benchmark import run_jobs, same_result
from springopt.benchmark.suite import choose_scenes, make_jobs
from springopt.store import read

SCENES = ("paper-fem-2d", "paper-topology-2d-isotropic")
OPTIMIZERS = ("random-search", "paper-ga", "l-bfgs-b")


@contextlib.contextmanager
def cluster(folder, worker_count):
    """The scheduler file, and the processes of the workers."""
    file, log = folder / "scheduler.json", (folder / "cluster.log").open("w")

    def start(program, *options):
        command = [sys.executable, "-m", f"distributed.cli.{program}", "--scheduler-file", str(file), *options]
        return subprocess.Popen(command, stdout=log, stderr=log, cwd=folder)

    processes = [start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--dashboard-address", ":0")]
    worker = ("--nthreads", "1", "--no-nanny", "--dashboard-address", ":0", "--local-directory", str(folder))
    processes += [start("dask_worker", *worker) for _ in range(worker_count)]
    try:
        while not file.exists():
            time.sleep(0.05)
        yield file, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()
        log.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--evaluations", type=int, default=1500)
    given = parser.parse_args()
    jobs = make_jobs(choose_scenes(SCENES), OPTIMIZERS, given.seeds, {"evaluations": given.evaluations})
    with tempfile.TemporaryDirectory() as name, cluster(Path(name), given.workers) as (address, workers):
        folder, ended = Path(name), itertools.count(1)

        def kill_one_in_the_middle(standing):
            if next(ended) == len(jobs) // 3:
                os.kill(workers[0].pid, signal.SIGKILL)
                print(f"killed one of {given.workers} workers after {standing.ended} of {standing.jobs} jobs")

        began = time.perf_counter()
        outcomes = run_jobs(jobs, folder / "cluster", dask=str(address), progress=kill_one_in_the_middle)
        print(
            f"{len(jobs)} jobs on the cluster in {time.perf_counter() - began:.1f} s; the worker: {workers[0].poll()}"
        )
        local = run_jobs(jobs, folder / "local")
        states = [[each.state for each in of_place] for of_place in (outcomes, local)]
        runs = [job for job, outcome in zip(jobs, local, strict=True) if outcome.state == "done"]
        same = [
            same_result(read(job.run_file(folder / "cluster")), read(job.run_file(folder / "local"))) for job in runs
        ]
    print(f"the same states: {states[0] == states[1]}; {sum(same)} of {len(runs)} runs identical to the local ones")


if __name__ == "__main__":
    main()
