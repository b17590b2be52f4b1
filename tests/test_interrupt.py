import os
import signal
import threading

import pytest

from springopt.interrupt import held_interrupts


def test_ctrl_c_is_held_back_and_told():
    before = signal.getsignal(signal.SIGINT)
    with held_interrupts() as pressed:
        assert not pressed()
        os.kill(os.getpid(), signal.SIGINT)
        assert pressed()
    assert signal.getsignal(signal.SIGINT) is before


def test_the_second_ctrl_c_is_let_through():
    def press_twice():
        with held_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        press_twice()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_outside_the_main_thread_nothing_is_changed():
    told = []

    def work():
        with held_interrupts() as pressed:
            told.append(pressed())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert told == [False]
