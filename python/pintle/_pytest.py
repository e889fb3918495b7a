"""The pytest plugin: the fixture `pintle_check`."""

import pytest


@pytest.fixture
def pintle_check():
    """Checks a routine as `pintle.check` does, with the same arguments, and fails the test with the matrix and the cause."""
    from . import check

    def run(routine, of, **options):
        __tracebackhide__ = True
        report = check(routine, of, **options)
        report.assert_ok()
        return report

    return run
