"""Engines: every item ends once, whatever happens to workers, and in whatever order they end."""

from __future__ import annotations

import functools
import logging
import os
from collections import Counter
from pathlib import Path

import plain_work
import psutil
import pytest

from vdoor.engines import Ended, Limits, OutOfMemoryError, WorkerDiedError, dask, in_order, over, processes
from vdoor.engines.loopback import loopback_cluster
from vdoor.errors import MapError, SettingError, VdoorError

TWO = Limits(workers=2)


def test_results_come_in_order_whatever_the_order_of_their_ends() -> None:
    shuffled = [Ended(number=number, result=str(number)) for number in (2, 0, 1, 4, 3)]
    assert list(in_order(shuffled)) == ["0", "1", "2", "3", "4"]


def test_processes_are_a_map_whose_errors_and_warnings_arrive() -> None:
    with over(2) as each, pytest.warns(UserWarning, match="number [123]"):
        assert list(each(plain_work.reciprocal, [1, 2, 3])) == [1, 1 / 2, 1 / 3]
    with over(2) as each, pytest.raises(MapError, match=r"^zero: wanted another number, found 0$"):
        list(each(plain_work.reciprocal, [0]))


def test_one_process_is_this_one_and_more_are_kept_from_call_to_call() -> None:
    with over(1) as each:
        assert set(each(plain_work.own_process, range(3))) == {os.getpid()}
    with over(2) as each:
        first, second = (set(each(plain_work.own_process, range(9))) for _ in range(2))
    assert os.getpid() not in first
    assert len(first | second) <= 2


def test_an_item_whose_worker_dies_is_tried_twice_and_the_others_once(tmp_path: Path) -> None:
    work = functools.partial(plain_work.die_of, poison=2, log=tmp_path / "log")
    found = sorted(processes(work, range(5), TWO), key=lambda one: one.number)
    assert [one.result for one in found] == [0, 1, None, 3, 4]
    assert isinstance(found[2].error, WorkerDiedError)
    assert Counter((tmp_path / "log").read_text().split()) == {"0": 1, "1": 1, "2": 2, "3": 1, "4": 1}


def test_an_item_that_eats_memory_fails_alone() -> None:
    found = sorted(processes(plain_work.eat, [10, 3000, 20], Limits(memory_mb=1500)), key=lambda one: one.number)
    assert [one.result for one in found] == [10, None, 20]
    assert isinstance(found[1].error, OutOfMemoryError)
    assert str(found[1].error) == "memory: wanted no more than 1500 MB, found work that needs more"


def test_a_cluster_does_the_same_and_its_loss_is_one_clear_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(plain_work.__file__).parent))
    with loopback_cluster(tmp_path) as there:
        limits = Limits(scheduler=there.address)
        listening = psutil.Process(there.scheduler.pid).net_connections("inet")
        assert {one.laddr.ip for one in listening} == {"127.0.0.1"}
        work = functools.partial(plain_work.die_of, poison=2, log=tmp_path / "log")
        found = sorted(dask(work, range(5), limits), key=lambda one: one.number)
        assert [one.result for one in found] == [0, 1, None, 3, 4]
        assert Counter((tmp_path / "log").read_text().split())["2"] == 2
        there.workers[0].kill()
        assert list(in_order(dask(plain_work.squared, range(100), limits))) == [n * n for n in range(100)]
        assert not logging.getLogger("distributed.client").isEnabledFor(logging.ERROR)
        endings = dask(plain_work.own_process, range(100_000), limits)
        next(endings)
        there.scheduler.kill()
        with pytest.raises(VdoorError, match=rf"^scheduler: wanted an answer, found .* goes on .*: {there.address}$"):
            list(endings)


def test_a_cluster_wants_a_scheduler() -> None:
    with pytest.raises(SettingError, match="wanted --scheduler with it"):
        list(dask(plain_work.squared, [1], Limits()))
