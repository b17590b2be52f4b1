"""The pictures of a reproduction: what is drawn where."""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from springopt.report.bands import draw_bands
from springopt.report.rows import draw_rows
from springopt.runner import solve
from springopt.store import read


def test_bands_show_the_median_of_the_runs_and_what_lies_between_best_and_worst() -> None:
    curves = {"fast": np.array([[3.0, 1.0, 0.0], [3.0, 2.0, 1.0], [3.0, 3.0, 2.0]]), "slow": np.full((2, 3), 4.0)}
    early, whole = draw_bands(curves, xlabel="generation", ylabel="cost", early=2).axes
    assert early.lines[0].get_ydata().tolist() == [3.0, 2.0]
    assert whole.lines[0].get_ydata().tolist() == [3.0, 2.0, 1.0]
    assert whole.get_yscale() == "log"
    assert [text.get_text() for text in early.get_legend().get_texts()] == ["fast", "slow"]
    band = early.collections[0]
    assert isinstance(band, PolyCollection)
    assert band.get_paths()[0].vertices[:, 1].min() == 1.0


def test_rows_show_loads_reference_and_model_and_dash_what_is_missing(tmp_path) -> None:
    run = solve("paper-topology-3d", "random-search", evaluations=1, out=tmp_path / "a.h5")
    file = read(tmp_path / "a.h5")
    figure = draw_rows(file, ["stretch x", "shear z along x"], ["one", "two"])
    axes = np.array(figure.axes).reshape(3, 2)
    assert [panel.get_title() for panel in axes[0]] == ["stretch x", "shear z along x"]
    assert [panel.get_ylabel() for panel in axes[:, 0]] == ["loads", "reference", "model"]
    assert [panel.get_xlabel() for panel in axes[2]] == ["one", "two"]
    dashed = [lines for lines in axes[2, 0].collections if isinstance(lines, LineCollection)][-1]
    assert len(dashed.get_segments()) == np.count_nonzero(run.stiffness == 0)
