"""A fixture of pytest: def test_my_row(pintle_check): pintle_check(my_row, "REVOLUTE")."""

import pytest

import pintle


@pytest.fixture
def pintle_check():
    """Checks a routine as pintle.check does, and fails with what is wrong and why."""

    def checked(routine, of, **keywords):
        __tracebackhide__ = True
        report = pintle.check(routine, of, **keywords)
        report.assert_ok()
        return report

    return checked
