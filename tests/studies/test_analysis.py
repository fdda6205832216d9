"""The analysis on simulated crowds whose answer is known. Seeds are fixed, so that a result is the same each time. A bound that
holds by chance only states with which probability other seeds would miss it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from diaphane_studies import comfort, export, figures, intervals, latency, report, simulate, texts, tours, trials, viewpoints

CROWDS = 20


def _held(trial, name: str) -> int:
    return sum(trial(seed)[name] for seed in range(CROWDS))


def test_the_crowd_of_table_1_gives_table_1_back():
    held = [trials.comfort_trial(seed) for seed in range(CROWDS)]
    for name in held[0]:
        # Of 20 intervals with a level of 95%, fewer than 15 cover with probability 0.0003; 12 intervals: 0.4%.
        assert sum(one[name] for one in held) >= 15, name


def test_a_large_crowd_has_the_means_and_deviations_of_table_1():
    found = comfort.materials(simulate.comfort(np.random.default_rng(1), 20_000))
    for material, truth in zip(found, simulate.TABLE_1):
        # Five standard errors of a mean are 5 * 70 / sqrt(20000) = 2.5, and of a weighted one are twice that at most.
        assert np.abs(material.plain.mean - truth.mean).max() < 2.5
        assert np.abs(material.weighted.mean - truth.weighted).max() < 5
        assert material.plain.deviation == pytest.approx(truth.deviation, rel=0.05)
        assert material.effect


def test_without_an_effect_nothing_is_adoptable():
    # Each crowd claims an effect of any material with probability 1% at most: more than 3 of 20 with less than 0.001.
    assert _held(trials.no_effect_trial, "nothing adopted") >= CROWDS - 3
    assert report.analyse(simulate.comfort(np.random.default_rng(3), effect=False))["adoptable"]["comfort"] is None


def test_the_differences_of_bone_and_blood_are_adoptable():
    found = report.analyse(simulate.comfort(np.random.default_rng(3), 2000))["adoptable"]["comfort"]
    assert set(found) == {"bone", "blood"} and found["bone"][0] < 0 < found["blood"][0]


def test_figure_21_shows_the_materials_in_five_settings_from_left_to_right():
    found = comfort.materials(simulate.comfort(np.random.default_rng(3), 500))
    drawn = figures.figure_21(found, texts.Texts("en"), ["Bone", "Vessels"])
    pictures = [axes for axes in drawn.axes if axes.images]
    assert [axes.get_title() for axes in pictures] == ["−2", "−1", "0", "+1", "+2"]
    assert [axes.get_xlabel() for axes in pictures] == ["most uncomfortable", "", "Reference", "", "most comfortable"]
    owner, brightness, _ = figures.lit_forms(len(found))
    for axes, times in zip(pictures, (-2, -1, 0, 1, 2), strict=True):
        image = np.asarray(axes.images[0].get_array())
        assert (image[owner < 0] == 1).all()
        for number, material in enumerate(found):
            # Where the light is about as bright as white paper, a form has its colour, plus a highlight.
            lit = image[(owner == number) & (brightness > 0.9)]
            # Light of 0.9 is 0.955 in sRGB, and a highlight in front of it adds at most 0.3 of linear light.
            assert (np.median(lit, axis=0) >= 0.95 * material.colour(times) / 255 - 0.03).all()
            assert (lit.min(axis=0) <= material.colour(times) / 255 + 1 / 255).all()
    assert len({number for number in np.unique(owner) if number >= 0}) == len(found)


def test_a_rating_of_zero_weighs_as_much_as_one():
    assert comfort.weights_of(np.array([0.0, 1, 2, 10])).tolist() == [1, 1, 0.5, 0.1]


def test_a_component_that_nobody_changes_does_not_hide_an_effect_of_the_others():
    changes, weights = np.random.default_rng(1).normal([20, -20], 15, (20, 2)), np.ones(20)
    alone = intervals.hotelling(changes, weights)
    assert alone < 0.001
    for more in (np.zeros(20), changes.sum(axis=1)):    # nobody changed it, or it follows from the others
        assert intervals.hotelling(np.column_stack([changes, more]), weights) == pytest.approx(alone)
    assert intervals.hotelling(np.full((20, 3), 7.0), weights) == 1    # nothing varies


def test_a_share_has_the_interval_of_clopper_and_pearson():
    low, high = intervals.share(10, 16)
    assert (round(low, 3), round(high, 3)) == (0.354, 0.848)      # their published table


def test_planted_clusters_and_outliers_are_found():
    held = [trials.viewpoints_trial(seed) for seed in range(CROWDS)]
    for name in held[0]:
        # With the wanted 95%, fewer than 15 of 20 have probability 0.0003.
        assert sum(one[name] for one in held) >= 15, name


@pytest.mark.parametrize("kind", simulate.NOISE)
def test_a_crowd_without_clusters_yields_no_claim(kind):
    assert sum(trials.noise_trial(kind, seed)[kind] for seed in range(CROWDS)) >= 15


def test_the_threshold_of_latency_is_covered():
    # As above: two intervals.
    assert min(_held(trials.latency_trial, name) for name in ("threshold 50%", "threshold 75%")) >= 15


def test_no_threshold_is_claimed_if_the_delay_does_not_matter():
    document = simulate.latency(np.random.default_rng(1))
    for one in document["participants"]:
        for trial in one["answers"][0]["value"]["trials"]:
            trial["acceptable"] = (trial["delay_ms"] + one["number"]) % 3 > 0
    result = latency.analyse(document, "latency")
    assert result.parameters is None and not result.thresholds


def test_a_tour_is_closed_and_never_closer_than_the_participants():
    for seed in range(20):
        document, _ = simulate.viewpoints(np.random.default_rng(seed))
        [step] = export.steps(document, "viewpoint")
        result = viewpoints.analyse("viewpoint", viewpoints.views_of(document, step))
        closest = result.views.distances[result.kept].min()
        eyes = tours.curve(np.array([one.direction for one in result.clusters]), np.array([one.distance for one in result.clusters]))
        assert np.linalg.norm(eyes, axis=1).min() >= closest - 1e-9
        assert np.allclose(eyes[0], eyes[-1])
        for view in tours.cameras(result):
            assert np.linalg.norm(np.array(view["eye"]) - simulate.CENTRE) >= closest * simulate.RADIUS - 0.02    # rounded to 0.01 mm per axis
            assert abs(np.dot(view["up"], np.array(view["eye"]) - simulate.CENTRE)) < 0.01 * simulate.RADIUS * 4


def test_opposite_views_have_a_tour_around_the_body():
    eyes = tours.curve(np.array([[0.0, -1, 0], [0, 1, 0]]), np.array([3.0, 4]))
    assert np.linalg.norm(eyes, axis=1).min() >= 3 - 1e-9
    assert np.abs(eyes[:, 2]).max() < 1e-6    # about the long axis


def test_identical_views_are_one_view():
    document = simulate.noise("one view", np.random.default_rng(1))
    for one in document["participants"]:
        one["answers"][0]["value"] = document["participants"][0]["answers"][0]["value"]
    found = report.analyse(document)["adoptable"]["tours"]
    assert [len(one["views"]) for one in found] == [1]


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("kind", simulate.CROWDS)
def test_every_study_has_sections_and_figures_in_both_languages(kind, language):
    made = report.as_json(report.analyse(simulate.CROWDS[kind](np.random.default_rng(1), 43), language))
    json.dumps(made, allow_nan=False)
    assert len(made["sections"]) >= 2
    assert all(figure["svg"].lstrip().startswith("<?xml") for section in made["sections"] for figure in section["figures"])
    assert all(len(row) == len(table["columns"]) for section in made["sections"] for table in section["tables"] for row in table["rows"])


@pytest.mark.parametrize("kind", simulate.CROWDS)
@pytest.mark.parametrize("people", [0, 1, 2, 5, 9])
def test_few_or_no_participants_are_analysed(kind, people):
    document = simulate.CROWDS[kind](np.random.default_rng(1), 43)
    document["participants"] = document["participants"][:people]
    json.dumps(report.as_json(report.analyse(document)), allow_nan=False)


@pytest.mark.parametrize("data", [b"", b"[]", b"{", b'{"format": "other"}', b'{"format": "diaphane-study", "version": 2}', b'{"format": "diaphane-study", "version": 1}'])
def test_another_document_is_refused(data):
    with pytest.raises(export.ExportError):
        export.parse(data)


def test_an_answer_that_does_not_fit_is_refused_without_being_quoted():
    document = simulate.comfort(np.random.default_rng(1))
    document["participants"][0]["answers"][0]["value"] = {"secret": "a name"}
    with pytest.raises(export.ExportError) as error:
        report.analyse(document)
    assert "secret" not in str(error.value) and "name" not in str(error.value)
