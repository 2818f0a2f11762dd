"""How a thing is fetched with an arm: `step(fetch, event, now_s) -> (fetch, commands)`, pure."""
