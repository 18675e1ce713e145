"""Work of all visitors: in order, so many at once, and nobody waits for another one's long work."""

import threading
import time
from collections.abc import Iterator

import pytest
from live.server import wait_until

from beamviz.explorer import executor as threads
from beamviz.explorer.executor import Threads


@pytest.fixture
def going() -> Iterator[threading.Event]:
    """What lets long work go on, at the latest when the test is over."""
    event = threading.Event()
    yield event
    event.set()


def test_work_is_done_in_order_and_so_many_at_once(going):
    """Two begin; the others wait, and follow as they came."""
    pool, begun = Threads(2, "test"), []
    for k in range(6):
        pool.submit(lambda k: (begun.append(k), going.wait(20)), k)
    wait_until(lambda: len(begun) == 2)
    time.sleep(0.1)
    assert begun == [0, 1]
    going.set()
    wait_until(lambda: len(begun) == 6)
    assert sorted(begun[2:4]) == [2, 3]
    assert sorted(begun[4:]) == [4, 5]


def test_long_work_stops_nobody(going, monkeypatch):
    """Any number of pieces that never end: another one is done all the same, one by one."""
    monkeypatch.setattr(threads, "LONG", 0.1)
    pool, done = Threads(2, "test"), []
    for _ in range(9):
        pool.submit(going.wait, 60)
    for k in range(20):
        pool.submit(done.append, k)
    wait_until(lambda: len(done) == 20)
    assert sorted(done) == list(range(20))
    assert len(pool.begun) == 9


def test_threads_end_when_there_is_nothing_to_do(going):
    """None waits for work that may never come."""
    pool = Threads(3, "test that ends")
    futures = [pool.submit(pow, 2, k) for k in range(50)]
    assert [future.result(20) for future in futures] == [2**k for k in range(50)]
    wait_until(lambda: not [one for one in threading.enumerate() if one.name == "test that ends"])
    assert not pool.begun


def test_an_error_is_told_and_the_next_work_done():
    """The thread lives on."""
    pool = Threads(1, "test")
    first, second = pool.submit(divmod, 1, 0), pool.submit(divmod, 7, 2)
    assert second.result(20) == (3, 1)
    assert isinstance(first.exception(20), ZeroDivisionError)


def test_the_end_waits_for_nothing(going):
    """What waits is forgotten, what is being done is left to itself."""
    done = []
    with Threads(1, "test") as pool:
        pool.submit(going.wait, 60)
        pool.submit(done.append, 1)
    going.set()
    wait_until(lambda: not pool.begun)
    assert not done
