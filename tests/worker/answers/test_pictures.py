"""The pictures that can be asked for are those that can be drawn."""

from worker.answers.pictures import DRAWN
from worker.answers.plots import PLOTS


def test_every_plot_can_be_drawn() -> None:
    assert tuple(DRAWN) == PLOTS
