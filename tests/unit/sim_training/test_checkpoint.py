"""A training run that was broken off."""

from pathlib import Path

import pytest
import torch

from sim.training.checkpoint import Checkpoint

STATE = "detector.state"


def run(folder: Path, steps: int) -> tuple[Checkpoint, torch.nn.Linear]:
    """A little training, saved; the random numbers are those of its steps alone."""
    torch.manual_seed(1)
    model = torch.nn.Linear(3, 1)
    optimiser = torch.optim.AdamW(model.parameters(), lr=0.1)
    checkpoint = Checkpoint(folder / STATE, {"model": model, "optimiser": optimiser})
    for step in range(checkpoint.load(), steps):
        optimiser.zero_grad()
        (model(torch.tensor([step, 1.0, 2.0])) ** 2).sum().backward()
        optimiser.step()
        checkpoint.save(step + 1)
    return checkpoint, model


def test_it_goes_on_as_if_nothing_had_happened(tmp_path: Path) -> None:
    (tmp_path / "whole").mkdir()
    _, whole = run(tmp_path / "whole", 6)
    run(tmp_path, 4)
    _, broken_off = run(tmp_path, 6)
    assert torch.equal(broken_off.weight, whole.weight)


def test_a_run_that_is_done_leaves_nothing_to_go_on_with(tmp_path: Path) -> None:
    checkpoint, _ = run(tmp_path, 2)
    assert checkpoint.load() == 2
    checkpoint.done()
    assert checkpoint.load() == 0


def test_a_write_that_is_broken_off_leaves_the_step_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checkpoint, _ = run(tmp_path, 2)

    def full(*_: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(torch, "save", full)
    with pytest.raises(OSError, match="no space"):
        checkpoint.save(3)
    assert checkpoint.load() == 2
