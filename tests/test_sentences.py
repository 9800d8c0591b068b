"""A sentence reads in SI, keeps its values through joining, errors and processes, and is rendered from them."""

import pickle

import pytest

from strainwave.base.sentences import Angle, Sentence, Speed, told

JUMPS = Sentence("jumps by {} at {}", Angle(0.5), Speed(155.0, 168.0))


def tenfold(quantity):
    return quantity.written(lambda value, _: f"{10.0 * value:.0f}", quantity.unit.replace("rad", "drad"))


def test_a_sentence_reads_in_si():
    assert JUMPS == "jumps by 0.5 rad at 155 and 168 rad/s"
    assert Sentence("at {} to {}", Speed(1.23456789, digits=3, bare=True), Speed(2.0)) == "at 1.23 to 2 rad/s"
    assert Sentence("in {}", Speed()) == "in rad/s"
    assert Sentence("braces {} stay without values") == "braces {} stay without values"


def test_the_ends_of_a_band_are_rounded_outward_and_a_whole_number_stays():
    band = Speed(480.31, 864.2, digits=3, between=" to ", ways=(-1, 1))
    assert str(band) == "480 to 865 rad/s"
    assert str(Speed(0.48999999999999, 1.0000000000001, digits=2, ways=(-1, 1))) == "0.49 and 1 rad/s"
    assert str(Speed(0.4899, 1.001, digits=2, ways=(-1, 1))) == "0.48 and 1.1 rad/s"
    assert str(Speed(1706.4, 1706.4, digits=6, ways=(1, -1))) == "1706.4 and 1706.4 rad/s"


@pytest.mark.parametrize(
    "kept",
    [
        JUMPS,
        Sentence("{}", JUMPS),
        str(ValueError(JUMPS)),
        pickle.loads(pickle.dumps(JUMPS)),
        Sentence("; ").join([JUMPS]),
    ],
)
def test_its_values_survive_composition(kept):
    assert kept == JUMPS
    assert kept.told(tenfold) == "jumps by 5 drad at 1550 and 1680 drad/s"


def test_joined_and_added_sentences_are_rendered_whole():
    both = "a: " + Sentence("; ").join(["plain {}", JUMPS]) + "."
    assert both.told(tenfold) == "a: plain {}; jumps by 5 drad at 1550 and 1680 drad/s."


def test_every_sentence_of_plain_data_is_rendered_and_nothing_else_changed():
    data = {"a": [Sentence("{}", Speed(1.0)), "1 rad/s", 2.5], "b": None}
    assert told(data, tenfold) == {"a": ["10 drad/s", "1 rad/s", 2.5], "b": None}


def test_a_text_without_a_place_for_every_value_is_refused():
    with pytest.raises(ValueError, match="zip"):
        Sentence("at {}", Speed(1.0), Speed(2.0))
