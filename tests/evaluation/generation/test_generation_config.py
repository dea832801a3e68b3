"""Settings of training data: the grammar of experiments, and errors that say what to do."""

import pytest

from datasets_gen import InputError
from evaluation.experiment.config_sections import DatasetSection
from evaluation.generation import GenerationConfig
from evaluation.generation.generation_config import generation_presets
from evaluation.generation.generation_plan import make_generation_plan

HUMAN = '[[dataset]]\nname = "human"\n'


def refused(tmp_path, text):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        GenerationConfig.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name = \n", ["mine.toml", "not valid TOML"]),
        ('name = "x"\n', ["no [[dataset]]"]),
        ('[dataset]\nname = "human"\n', ["[[dataset]]", "two brackets"]),
        (f"seads = 1\n{HUMAN}", ["'seads'", "did you mean 'seed'"]),
        (f"seed = -1\n{HUMAN}", ["seed", "-1"]),
        (f"validation = 0.7\n{HUMAN}", ["validation", "0.7", "0.5"]),
        (f"timeout = 0\n{HUMAN}", ["timeout"]),
        (f"{HUMAN}[draw]\nthresholds = [0.1, 0.2]\n", ["[draw]", "'thresholds'", "'threshold'"]),
        (f"{HUMAN}[draw]\nthreshold = [0.9, 0.2]\n", ["[draw]", "lowest", "[0.9, 0.2]"]),
        (f"{HUMAN}[draw]\nthreshold = 0.5\n", ["[draw]", "threshold", "list", "0.5"]),
        (f"{HUMAN}[draw]\nper_render = 0\n", ["per_render", "0"]),
        (f'{HUMAN}[draw]\nturn = "down"\n', ["turn", "'down'"]),
        (f"{HUMAN}[draw]\nsweep = {{ threshold = [0.5] }}\n", ["threshold", "not in 'sweep'"]),
        (f"{HUMAN}[draw]\nsweep = {{ view = [3] }}\n", ["'view'", "did you mean 'views'"]),
        (f'{HUMAN}[draw]\nsweep = {{ "scanner.noize" = [0.1] }}\n', ["'noize'", "did you mean 'noise'"]),
        (f'{HUMAN}[draw]\nsweep = {{ "scanner.noise" = [7.0] }}\n', ["noise", "7"]),
        (f"{HUMAN}[scan]\nthreshold = 0.5\n", ["[scan]", "under [draw]"]),
        (f"{HUMAN}[scan]\npoints = 2\n", ["points", "2"]),
        (f"{HUMAN}[matching]\n", ["'matching'", "valid:"]),
    ],
    ids=lambda value: value.splitlines()[-1][:40] if isinstance(value, str) else "",
)
def test_wrong_settings_are_one_line(tmp_path, text, words):
    message = refused(tmp_path, text)
    for word in words:
        assert word in message


def test_viewpoints_given_as_matrices_are_not_turned(tmp_path):
    matrix = "[[[1.0,0,0,0],[0,1.0,0,0],[0,0,1.0,-9.0],[0,0,0,1.0]]]".replace(",0", ",0.0").replace(
        "[0,", "[0.0,"
    )
    text = f"{HUMAN}[scan]\nviews = {matrix}\n"
    assert 'turn = "none"' in refused(tmp_path, text)
    path = tmp_path / "still.toml"
    path.write_text(f'{text}[draw]\nturn = "none"\n')
    assert GenerationConfig.load(path).draw.turn == "none"


def test_unknown_presets_and_files_are_answered_with_those_there_are(tmp_path):
    with pytest.raises(InputError, match="'quik'; did you mean 'quick'"):
        GenerationConfig.load("quik")
    with pytest.raises(InputError, match=r"none\.toml.*presets: bodies, quick"):
        GenerationConfig.load(tmp_path / "none.toml")


@pytest.mark.parametrize("name", sorted(generation_presets()))
def test_settings_written_out_are_read_back(tmp_path, name):
    config = GenerationConfig.load(name)
    path = tmp_path / "again.toml"
    path.write_text(config.to_toml(), encoding="utf-8")
    assert GenerationConfig.load(path) == config
    assert config.description


def test_sections_are_those_of_experiments(tmp_path):
    (tmp_path / "body").mkdir()
    path = tmp_path / "mine.toml"
    path.write_text('[[dataset]]\nname = "body"\nposes = ["a", "b"]\n[scan]\nviews = "opposed"\n')
    config = GenerationConfig.load(path)
    assert config.dataset == (DatasetSection(name=str(tmp_path / "body"), poses=("a", "b")),)
    assert (config.name, config.scan.views, config.scan.points) == ("mine", "opposed", 2048)


def test_more_shards_than_a_folder_takes_are_refused_before_they_are_counted():
    with pytest.raises(InputError, match=r"99,999,999,999,999 samples.*--shard-size"):
        make_generation_plan(GenerationConfig.load("quick"), 99_999_999_999_999, 100)
