"""Waiting for what other programs do, within bounds."""

import time

PATIENCE = 40.0  # s until something that should happen counts as missing; a loaded machine is slow


def wait_until(condition, what, patience=PATIENCE):
    """The first value of `condition()` that is true; fails after `patience` seconds. `what` may be a function that says how things are then."""
    deadline = time.monotonic() + patience
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {patience} s for {what() if callable(what) else what}; last: {value!r}")
        time.sleep(0.02)
