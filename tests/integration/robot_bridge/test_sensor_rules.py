"""Every cell of docs/sensors.md is true, and the page holds every cell."""

import pytest

from support.sensor_rules import PAGE, Cell, Table, page
from support.sensor_tables import TABLES

CELLS = [
    pytest.param(table, cell, id=f"{table.message}: {cell.field}: {cell.case}{' ' * bool(cell.settings)}")
    for table in TABLES
    for cell in table.cells
]


@pytest.mark.parametrize(("table", "cell"), CELLS)
def test_a_field_that_makes_no_sense_is_never_believed_and_its_reason_is_told(table: Table, cell: Cell) -> None:
    assert table.see(cell) == cell.told


def test_the_page_tells_every_cell() -> None:
    """To write it anew: PYTHONPATH=tests .venv/bin/python -m support.sensor_tables"""
    text = PAGE.read_text(encoding="utf-8")
    assert text == page(text, TABLES)
