"""Several processes at the same jobs: the results of one, whatever happens to a process."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from multiprocessing import active_children
from pathlib import Path

import pytest

from springopt.benchmark import run_jobs, same_result
from springopt.journal import require_unused
from springopt.store import read


def kill_a_child_when(condition, times=1):
    """Kills a process of this one each time that the condition holds, in a thread."""

    def watch():
        for _ in range(times):
            while not condition():
                time.sleep(0.01)
            child = active_children()[0]
            os.kill(child.pid, signal.SIGKILL)
            while child in active_children():
                time.sleep(0.01)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    return thread


@pytest.mark.slow
def test_they_give_the_results_of_one_process_even_if_one_of_them_is_killed(nine, job, tmp_path):
    jobs = [job(nine, optimizer, seed) for optimizer in ("random-search", "maciel-angles") for seed in range(4)]
    jobs += [job(nine, label="long", limits={"evaluations": 20_000}, seed=seed) for seed in range(2)]
    several, one = tmp_path / "several", tmp_path / "one"
    watch = kill_a_child_when(lambda: list(several.glob("nine/long/*.journal")))
    outcomes = run_jobs(jobs, several, workers=2)
    watch.join()
    assert [each.state for each in outcomes] == ["done"] * 10
    run_jobs(jobs, one)
    for each in jobs:
        assert same_result(read(each.run_file(several)), read(each.run_file(one)))
    assert not active_children()


@pytest.mark.slow
def test_a_job_that_kills_its_process_twice_has_failed(nine, job, tmp_path):
    kill_a_child_when(lambda: list(tmp_path.glob("nine/random-search/*.journal")) and active_children(), times=2)
    (outcome,) = run_jobs([job(nine, limits={"seconds": 600})], tmp_path, workers=2)
    assert outcome.state == "failed"
    assert outcome.sentence.startswith("its process was killed by signal 9, 2 times, perhaps for want of memory;")


@pytest.fixture
def at_work(tmp_path):
    """The command at two long runs, each in a process of its own, in a session of its own."""
    command = [sys.executable, "-c", "from springopt.cli import main; main()", "benchmark", "--workers", "2"]
    command += ["--scenes", "paper-fem-2d", "--optimizers", "random-search", "--seeds", "2", "--seconds", "600"]
    started = subprocess.Popen(
        [*command, "--out", "results"], cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    while len([journal for journal in journals(tmp_path) if journal.stat().st_size]) < 2:
        time.sleep(0.05)
        assert started.poll() is None
    yield started
    with suppress(ProcessLookupError):
        os.killpg(started.pid, signal.SIGKILL)


def journals(folder):
    return list(Path(folder, "results", "paper-fem-2d", "random-search").glob("*.journal"))


@pytest.mark.slow
def test_ctrl_c_ends_all_processes_and_leaves_their_journals(at_work, tmp_path):
    os.killpg(at_work.pid, signal.SIGINT)  # as a terminal does: to every process of the command
    assert_ended_cleanly(at_work, tmp_path)


@pytest.mark.slow
def test_so_does_sigterm_to_the_command_alone(at_work, tmp_path):
    at_work.terminate()
    assert_ended_cleanly(at_work, tmp_path)


def assert_ended_cleanly(at_work, folder):
    _, said = at_work.communicate(timeout=60)
    assert at_work.returncode == 130
    assert said.split("\n") == ["What ended is in results; the same command goes on.", "", "Interrupted.", ""]
    assert len(journals(folder)) == 2
    for journal in journals(folder):
        require_unused(journal)


@pytest.mark.slow
def test_they_end_where_the_command_is_killed(at_work, tmp_path):
    at_work.kill()
    at_work.communicate(timeout=60)  # until the last of them has closed standard error
    assert len(journals(tmp_path)) == 2
    for journal in journals(tmp_path):
        require_unused(journal)
