"""Threads that share the work of a batch; kernels run without the interpreter lock."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import cache


def run_all(tasks: Sequence[Callable[[], None]], threads: int) -> None:
    """Run independent tasks, in as many threads; the first error of one is raised."""
    if threads == 1 or len(tasks) == 1:
        for task in tasks:
            task()
        return
    futures = [_pool(threads).submit(task) for task in tasks]
    try:
        for future in wait(futures, return_when=FIRST_EXCEPTION).done:
            future.result()
    finally:  # after an error or Ctrl-C nobody waits for the others
        for future in futures:
            future.cancel()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="springopt")


if hasattr(os, "register_at_fork"):  # a forked process has none of its parent's threads
    os.register_at_fork(after_in_child=_pool.cache_clear)
