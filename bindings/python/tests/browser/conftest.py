"""A server and a page for each test of the widget in a browser."""

from collections.abc import Iterator
from pathlib import Path

import lab
import pytest


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[lab.Server]:
    lacking = lab.missing()
    if lacking is not None:
        pytest.skip(lacking)
    server = lab.Server(Path(tmp_path_factory.mktemp("lab")))
    yield server
    server.stop()


@pytest.fixture
def page(server: lab.Server) -> Iterator[lab.Page]:
    page = lab.Page(server)
    yield page
    page.close()
