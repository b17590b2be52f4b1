"""Jobs on a Dask cluster: the results of one process, whatever happens to a worker; what can't give them is refused."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from springopt.benchmark import cluster, run_jobs, same_result
from springopt.errors import UserError
from springopt.journal import Journal, journal_path
from springopt.random_search import RandomSearch
from springopt.store import read

distributed = pytest.importorskip("distributed")


def local_cluster(threads=1):
    """A scheduler and a worker in this process, where what a test changes holds too."""
    return distributed.LocalCluster(
        n_workers=1, threads_per_worker=threads, processes=False, protocol="tcp", dashboard_address=":0"
    )


@pytest.fixture(scope="module")
def address():
    with local_cluster() as running:
        yield running.scheduler_address


def broken(self, problem, rng):
    problem.evaluate(problem.sample(rng, 3))
    raise ZeroDivisionError("its own mistake")


def files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_it_gives_the_results_of_this_process(nine, bits, job, address, tmp_path):
    jobs = [job(scene, optimizer) for scene in (nine, bits) for optimizer in ("random-search", "maciel-angles")]
    far, here = tmp_path / "far", tmp_path / "here"
    outcomes = run_jobs(jobs, far, dask=address)
    assert [(each.state, each.word) for each in outcomes] == [("done", None)] * 3 + [("refused", "real")]
    assert [each.state for each in run_jobs(jobs, here)] == [each.state for each in outcomes]
    assert files(far) == files(here)
    assert outcomes[0].run == str(far / "nine" / "random-search" / "seed0.h5")
    for each in jobs[:3]:
        assert same_result(read(each.run_file(far)), read(each.run_file(here)))


def test_a_run_that_failed_there_can_be_taken_up_here_and_the_other_way_round(
    nine, job, address, tmp_path, monkeypatch
):
    one, jobs = tmp_path / "nine" / "random-search" / "seed0.h5", [job(nine)]
    for first, then in ((address, None), (None, address)):
        monkeypatch.setattr(RandomSearch, "minimize", broken)
        (outcome,) = run_jobs(jobs, tmp_path, dask=first)
        assert outcome.state == "failed"
        assert f"then go on from {journal_path(one)}, which has its answers" in outcome.sentence
        assert journal_path(one).stat().st_size
        monkeypatch.undo()
        monkeypatch.setattr(RandomSearch, "minimize", lambda self, p, rng: p.evaluate(p.sample(rng, 3)))
        assert run_jobs(jobs, tmp_path, dask=then)[0].state == "done"
        assert files(one.parent) == ["seed0.h5"]
        one.unlink()


def test_the_scheduler_s_file_tells_where_it_is(nine, job, address, tmp_path):
    (tmp_path / "scheduler.json").write_text(json.dumps({"address": address}))
    assert run_jobs([job(nine)], tmp_path, dask=str(tmp_path / "scheduler.json"))[0].state == "done"


def test_a_run_that_another_process_is_at_is_not_sent(nine, job, address, tmp_path, monkeypatch):
    monkeypatch.setattr(RandomSearch, "minimize", broken)
    run_jobs([job(nine)], tmp_path)
    monkeypatch.undo()
    with Journal.open(journal_path(job(nine).run_file(tmp_path))):
        outcomes = run_jobs([job(nine), job(nine, seed=1)], tmp_path, dask=address)
    assert [each.state for each in outcomes] == ["elsewhere", "done"]


def test_what_is_under_way_ends_where_the_caller_ends(nine, job, address, tmp_path):
    def stop(standing):
        raise KeyboardInterrupt

    jobs = [job(nine), job(nine, seed=1, limits={"seconds": 600})]
    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs, tmp_path, dask=address, progress=stop)
    began = time.perf_counter()
    assert run_jobs([job(nine, seed=2)], tmp_path, dask=address)[0].state == "done"
    assert time.perf_counter() - began < 60


class TestRefusals:
    def test_a_worker_of_another_build(self, nine, job, address, tmp_path, monkeypatch):
        def builds_of(names):
            here = threading.current_thread() is threading.main_thread()
            return {name: {"numpy": "2.4" if here else "1.9"} for name in names}

        monkeypatch.setattr(cluster, "builds_of", builds_of)
        with pytest.raises(
            UserError, match=r"on worker tcp://\S+ numpy is 1.9 and here 2.4, .*; install the same there"
        ):
            run_jobs([job(nine)], tmp_path, dask=address)

    def test_a_worker_without_the_plugin(self, nine, job, address, tmp_path, monkeypatch):
        def builds_of(names):
            if threading.current_thread() is not threading.main_thread():
                raise UserError("there is no optimizer 'random-search'.")
            return {name: {} for name in names}

        monkeypatch.setattr(cluster, "builds_of", builds_of)
        with pytest.raises(UserError, match=r"worker tcp://\S+ can't run this .*there is no optimizer"):
            run_jobs([job(nine)], tmp_path, dask=address)

    def test_workers_of_several_threads(self, nine, job, tmp_path):
        with local_cluster(threads=2) as running, pytest.raises(UserError, match="start it with --nthreads 1"):
            run_jobs([job(nine)], tmp_path, dask=running.scheduler_address)

    def test_an_address_where_nobody_answers(self, nine, job, tmp_path, monkeypatch):
        monkeypatch.setattr(cluster, "PATIENCE", 0.2)
        with pytest.raises(UserError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:1' "):
            run_jobs([job(nine)], tmp_path, dask="tcp://127.0.0.1:1", ready=lambda: pytest.fail("it is not"))

    @pytest.mark.parametrize("text", ["[lattice]", "{}", "[]", '{"address": "bogus://x"}'])
    def test_a_file_that_is_no_scheduler_s(self, nine, job, tmp_path, text):
        (tmp_path / "scheduler.json").write_text(text)
        with pytest.raises(UserError, match=r"no Dask scheduler answers at .*scheduler.json' \("):
            run_jobs([job(nine)], tmp_path, dask=str(tmp_path / "scheduler.json"))

    def test_a_missing_library(self, nine, job, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "distributed", None)
        with pytest.raises(UserError, match=r"needs the library distributed; install springopt\[dask\]"):
            run_jobs([job(nine)], tmp_path, dask="tcp://127.0.0.1:1")


@pytest.mark.slow
def test_of_several_workers_one_may_be_killed():
    script = Path(__file__).parents[2] / "benchmarks" / "dask_cluster.py"
    command = [sys.executable, str(script), "--seeds", "2", "--evaluations", "300"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    *_, killed, said = done.stdout.splitlines()
    assert killed.endswith("the worker: -9")
    assert said == "the same states: True; 10 of 10 runs identical to the local ones"
