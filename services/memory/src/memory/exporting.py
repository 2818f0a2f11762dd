"""Memory given away, line by line, in the forms that `memory.exchange` knows."""

from collections.abc import AsyncGenerator

from contracts.memory import ExportForm
from memory import exchange
from memory.ports import Store
from memory.whereabouts import Whereabouts


async def exported(store: Store, whereabouts: Whereabouts, form: ExportForm, *, views_max: int) -> AsyncGenerator[str]:
    if form is ExportForm.FULL:
        begun = False
        async for page in store.export_batches():
            yield ("" if begun else exchange.header_line()) + "".join(exchange.lines_of(page))
            begun = True
        return
    between, here = "{\n", (await whereabouts.here()).number
    for known in await store.labels(10_000, here):
        views = await store.views(known.label, views_max, here)
        yield between + exchange.seeds_of(known.label, views)
        between = ",\n"
    yield "{}\n" if between == "{\n" else "\n}\n"
