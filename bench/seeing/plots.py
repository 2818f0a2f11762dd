"""Plots of the benches, as PNG."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bench.results import pyplot

Confusion = Mapping[str, Mapping[str, list[int]]]
"""True colour -> colour asked for -> [confirmed, asked]."""


def save_confusion(path: Path, tables: Mapping[str, Confusion]) -> None:
    """One panel a detector: how often a thing of one colour was confirmed as another."""
    plt = pyplot()
    figure, axes = plt.subplots(1, len(tables), figsize=(7 * len(tables), 6.2), squeeze=False)
    for axis, (name, table) in zip(axes[0], tables.items(), strict=True):
        colours = sorted({*table, *(asked for row in table.values() for asked in row)})
        shares = np.full((len(colours), len(colours)), np.nan)
        for i, true in enumerate(colours):
            for j, asked in enumerate(colours):
                confirmed, of = table.get(true, {}).get(asked, [0, 0])
                if of:
                    shares[i, j] = confirmed / of
                    axis.text(j, i, f"{confirmed}\n/{of}", ha="center", va="center", fontsize=7)
        axis.imshow(shares, vmin=0.0, vmax=1.0, cmap="Blues")
        axis.set_xticks(range(len(colours)), colours, rotation=45, ha="right")
        axis.set_yticks(range(len(colours)), colours)
        axis.set_xlabel("colour asked for")
        axis.set_ylabel("colour it has")
        axis.set_title(f"{name}: things spotted that the votes confirmed")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def save_bars(path: Path, title: str, bars: Mapping[str, tuple[float, float]], unit: str) -> None:
    """Two bars a name: p50 and p99."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(7, 3.5))
    places = np.arange(len(bars))
    for offset, which in ((-0.2, 0), (0.2, 1)):
        values = [pair[which] for pair in bars.values()]
        drawn = axis.bar(places + offset, values, 0.4, label=("p50", "p99")[which])
        axis.bar_label(drawn, fmt="%.1f", fontsize=8)
    axis.set_xticks(places, list(bars))
    axis.set_ylabel(unit)
    axis.set_title(title)
    axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def save_memory(path: Path, samples: list[tuple[int, float]]) -> None:
    """Resident memory over frames seen."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(7, 3.5))
    axis.plot([frames for frames, _ in samples], [rss_mb for _, rss_mb in samples])
    axis.set_ylim(bottom=0)
    axis.set_xlabel("frames looked at")
    axis.set_ylabel("resident memory, MB")
    axis.set_title("Memory of the inference service")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
