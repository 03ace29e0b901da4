"""Tests marked `slow` are left out of ./test --quick."""
import os

import pytest


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: left out of ./test --quick")


def pytest_collection_modifyitems(items):
    if os.environ.get("TACTUS_QUICK"):
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(pytest.mark.skip(reason="slow"))
