"""Who is answered when: on threads while visitors are few, in turn where they are many."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from live.server import wait_until

from beamviz.explorer import solve_queue as turns
from beamviz.explorer.solve_queue import Turns


class Pool(ThreadPoolExecutor):
    """Threads that know what was left to them."""

    def __init__(self) -> None:
        super().__init__(1)
        self.given: list[Callable] = []

    def submit(self, work, /, *given, **named):
        self.given.append(work)
        return super().submit(work, *given, **named)


@pytest.fixture
def pool() -> Iterator[Pool]:
    """One thread."""
    with Pool() as made:
        yield made


@pytest.fixture
def crowd(pool) -> Iterator[Turns]:
    """Turns of many."""
    made = Turns(pool, lambda: True)
    yield made
    made.close()


def yes() -> bool:
    """It will be quick."""
    return True


def helpers() -> int:
    """The threads that somebody waits for."""
    return sum(thread.name == "helper" for thread in threading.enumerate())


def test_few_visitors_are_answered_at_once(pool):
    """On threads; nothing waits."""
    alone, done = Turns(pool), threading.Event()
    alone.submit(done.set, yes)
    assert done.wait(20)
    assert not alone.waiting


def test_in_a_crowd_all_come_in_turn(crowd, pool):
    """So many at a time, in order, and they are done when `take` is."""
    done: list[int] = []
    for k in range(5):
        crowd.submit(lambda k=k: done.append(k), yes)
    assert not done
    crowd.take(2)
    assert done == [0, 1]
    crowd.take(9)
    crowd.take(9)
    assert done == [0, 1, 2, 3, 4]
    assert not pool.given


def test_who_has_chosen_what_is_slow_goes_to_a_thread(crowd, pool):
    """Before it lines up, or while it waits."""
    quick, done = [True], threading.Event()
    crowd.submit(done.set, lambda: quick[0])
    quick[0] = False
    crowd.take(1)
    assert done.wait(20)
    crowd.submit(done.clear, lambda: quick[0])
    wait_until(lambda: not done.is_set())
    assert len(pool.given) == 2
    assert not crowd.waiting


def test_what_takes_long_in_spite_of_all_holds_up_nobody(crowd, monkeypatch):
    """It goes on beside; those after it are next, in order, and no thread stays in the end."""
    monkeypatch.setattr(turns, "PATIENCE", 0.2)
    before, begun, enough = helpers(), threading.Event(), threading.Event()
    done: list[int] = []
    for k in (1, 2):
        crowd.submit(lambda k=k: done.append(k), yes)
        crowd.submit(lambda: (begun.set(), enough.wait(60), done.append(-1)), yes)
    crowd.submit(lambda: done.append(3), yes)
    try:
        for _ in range(5):
            crowd.take(9)
        assert begun.is_set()
        assert done == [1, 2, 3]
    finally:
        enough.set()
    wait_until(lambda: sorted(done) == [-1, -1, 1, 2, 3])
    crowd.close()
    wait_until(lambda: helpers() == before)
