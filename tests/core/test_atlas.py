"""The reference against what is known exactly, and what follows from it for the fog models."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from foggy_synscapes.atlas import errors, fit, multiple_scattering, pathtracing, store
from foggy_synscapes.atlas.cells import GROUND, OPEN, Cell, cells
from foggy_synscapes.atlas.errors import Rung
from foggy_synscapes.atlas.scenes import Scene, scene
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog import ladder

WITHIN = 4
"""Standard errors."""


@pytest.fixture(scope="module")
def found() -> dict[Cell, store.Scattered]:
    return store.read()


def test_slabs_are_those_of_discrete_ordinates() -> None:
    """Path tracing against PythonicDISORT, both stored by benchmarks/fog_slabs.py."""
    table = pd.read_csv(Path(store.FILE).with_name("slabs.csv"))
    assert len(table) == 18
    off = (table["traced"] - table["ordinates"]) / table["standard_error"]
    assert off.abs().max() < WITHIN
    assert off.abs().mean() > 0.1  # independent of each other
    # Nothing is absorbed: all that does not come back comes through (the slab is lit by 1 from everywhere).
    light = table.pivot_table(index=["depth", "cosine"], columns="light", values="ordinates")
    assert (light["reflected"] + light["transmitted"]).to_numpy() == pytest.approx(1, abs=2e-5)


def test_the_reference_is_as_stored_and_small(found: dict[Cell, store.Scattered], tmp_path: Path) -> None:
    assert list(found) == cells()
    assert store.FILE.stat().st_size < 1 << 20
    copy = tmp_path / store.FILE.name
    copy.write_bytes(store.FILE.read_bytes()[:-1] + b"x")
    copy.with_suffix(".sha256").write_bytes(store.DIGEST.read_bytes())
    with pytest.raises(FoggyError, match=r"its sha256 is \w+\.\.\., but \w+\.\.\. is stated\. Make it again"):
        store.read(copy)


def test_scattered_light_darkens_a_street_under_a_bright_surround(found: dict[Cell, store.Scattered]) -> None:
    """It is the light of R - E, which is negative nearly everywhere; never below what would make a pixel negative."""
    for cell, one in found.items():
        assert one.mean.mean() < 0, cell
        assert errors.reference(cell, one).min() >= 0
    for frame in {cell.frame for cell in found}:
        ground, open_ = (found[Cell(frame, 0.02, beyond)].mean.mean() for beyond in (GROUND, OPEN))
        assert ground < open_  # a dark road below takes more away


def test_bounds_of_auto_are_those_of_the_reference(found: dict[Cell, store.Scattered]) -> None:
    """The packaged table is what `foggy atlas` makes of the stored reference, for one frame and rung at least."""
    known = ladder.factors()
    core = [cell for cell in found if cell.is_core and cell.surround == OPEN and cell.beta == 0.02]
    fitted = [cell for cell in core if fit.is_fitted(cell.frame)]
    lost = fit.shares(fitted)
    for model in ladder.RUNGS:
        rung = Rung(model, model) if model != ladder.DIMMED else Rung(model, "homogeneous", dimmed=ladder.SHARE[OPEN])
        ratios = [np.abs(errors.difference(rung, cell, found[cell])).mean() / lost[cell] for cell in fitted]
        betas, factors = known[OPEN, model]
        assert factors[betas.index(0.02)] == pytest.approx(max(ratios), abs=0.02)


def test_surround_is_nearer_to_path_tracing_than_uniform_airlight_on_frames_that_it_was_not_fitted_on(
    found: dict[Cell, store.Scattered],
) -> None:
    others = [cell for cell in found if cell.is_core and not fit.is_fitted(cell.frame) and cell.beta == 0.02]
    for cell in others:
        off = {
            rung.name: np.abs(errors.difference(rung, cell, found[cell])).mean()
            for rung in (Rung("surround", "surround"), Rung("uniform", "homogeneous"))
        }
        assert off["surround"] < off["uniform"], cell


def test_the_series_of_narasimhan_and_nayar_diverges_nearer_than_a_mean_free_path() -> None:
    with pytest.raises(ValueError, match=r"optical depth 0\.9: the series diverges, expected above 1"):
        multiple_scattering.coefficients(0.9)
    # What holds where it converges: the integral over the sphere is 4 pi / T^2, and nothing comes straight back.
    nodes, weights = np.polynomial.legendre.leggauss(200)
    for depth in (1.5, 2.0, 4.0):
        terms = 120
        intensity = multiple_scattering.intensity(depth, nodes, 0.9, terms)
        assert 2 * np.pi * (intensity * weights).sum() == pytest.approx(4 * np.pi / depth**2, rel=1e-9)
        assert multiple_scattering.intensity(depth, np.array([-1.0]), 0.9, terms)[0] == pytest.approx(0, abs=1e-9)
    ratios = [
        multiple_scattering.coefficients(1.05, terms=60)[m + 1] / multiple_scattering.coefficients(1.05)[m]
        for m in (40, 50)
    ]
    assert ratios[0] < ratios[1] < 1 / 1.05 + 1e-9


def test_cells_outside_of_physics_are_refused() -> None:
    for changed, told in (
        ({"albedo": 1.1}, r"albedo: 1\.1, expected 0 to 1"),
        ({"asymmetry": -1.0}, r"asymmetry: -1\.0, expected between -1 and 1"),
        ({"beta": 0.0}, r"beta: 0\.0, expected above 0"),
        ({"height": -5.0}, r"height: -5\.0, expected 0 \(homogeneous\) or above"),
        ({"surround": "sea"}, r"surround: 'sea', expected open, ground or sky"),
    ):
        with pytest.raises(ValueError, match=told):
            replace(Cell(0, 0.02), **changed)


def test_without_mitsuba_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "mitsuba", None)
    with pytest.raises(FoggyError, match=r"needs Mitsuba 3 .*pip install foggy-synscapes\[reference\]"):
        pathtracing.mitsuba()


def test_scattered_light_is_linear_in_what_shines_and_never_more_than_fog_takes() -> None:
    """A black scene, R - E = -E: each channel loses the same share of E, and at most what does not come straight."""
    pytest.importorskip("mitsuba", reason="needs the extra `reference`")
    plain, cell = scene(0), Cell(0, 0.02)
    black = Scene(np.zeros_like(plain.image), plain.depth, plain.labels, plain.camera, plain.pitch, plain.height)
    # The airlight is estimated from the image, so it is stated by the surround's own frame.
    beyond = plain.surround(OPEN)
    black.__dict__["surround"] = lambda _name: beyond
    share = pathtracing.scattered(black, cell, 4, 0) / -beyond
    assert np.ptp(share.mean(axis=(0, 1))) < 1e-4
    lost = 1 - np.exp(-cell.beta * plain.depth * errors.along(plain).factor())
    assert 0.2 * lost.mean() < share.mean() < lost.mean()


def test_the_stored_reference_is_what_path_tracing_gives(found: dict[Cell, store.Scattered]) -> None:
    pytest.importorskip("mitsuba", reason="needs the extra `reference`")
    cell = Cell(0, 0.02)
    again = store.blocks(pathtracing.scattered(scene(0), cell, store.SAMPLES, seed=99))
    off = (again - found[cell].mean) / (found[cell].error * np.sqrt(store.SEEDS + 1))
    assert np.abs(off.mean()) < WITHIN / np.sqrt(off.size) * 10  # blocks of one seed are not independent
    assert np.sqrt((off**2).mean()) < 2


def test_what_models_take_as_fitted_is_what_fits(found: dict[Cell, store.Scattered]) -> None:
    from foggy_synscapes.fog.models.surround import FITTED

    for beyond in (OPEN, GROUND):
        assert fit.surround(found, beyond) == FITTED[beyond]
        assert fit.dimmed(found, beyond) == ladder.SHARE[beyond]
