"""Scenes as files and as dicts, and what is said of wrong ones."""
import numpy as np
import pytest
import yaml

import unibody
from conftest import SOURCE


def test_a_dict_is_read_as_the_file_is(state_of_program):
    path = SOURCE / "scenes" / "mixed_pile.yaml"
    with open(path, encoding="utf-8") as file:
        content = yaml.safe_load(file)
    scene = unibody.Scene(content, folder=str(path.parent), set={"time.frames": 12})
    with unibody.Simulation(scene) as simulation:
        simulation.step(12 * scene.substeps)
        assert simulation.state_hash() == state_of_program(path, "-set", "time.frames=12")


def test_numbers_keep_all_of_their_digits(ball):
    place = [1 / 3, -1e-17, 12345678.90123456]
    ball["bodies"][0]["position"] = place
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        assert simulation.positions[0].tolist() == place


def test_arrays_and_numbers_of_numpy_are_taken(ball):
    ball["bodies"][0]["position"] = np.array([1.0, 2.0, 3.0])
    ball["time"]["frames"] = np.int64(7)
    ball["bodies"][0]["mass"] = np.float64(3)
    scene = unibody.Scene(ball)
    assert scene.frames == 7
    with unibody.Simulation(scene) as simulation:
        assert simulation.positions[0].tolist() == [1, 2, 3]


def test_a_title_may_be_any_text(ball):
    ball["title"] = 'a "quoted" title: with {marks}, # and\na line end'
    assert unibody.Scene(ball).title == ball["title"]


def test_set_takes_the_place_of_what_the_scene_says(ball):
    scene = unibody.Scene(ball, set={"bodies[0].position": [4, 5, 6], "solver.name": "gauss_seidel", "time.substeps": 3})
    assert scene.substeps == 3
    with unibody.Simulation(scene) as simulation:
        assert simulation.positions[0].tolist() == [4, 5, 6]


def test_an_error_of_a_file_has_its_place(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("time: {frame: 0.01}\nbodies:\n  - shape: {sphere: {radius: -1}}\n", encoding="utf-8")
    with pytest.raises(unibody.InputError) as error:
        unibody.Scene.load(str(path))
    assert error.value.file == str(path)
    assert error.value.line == 3
    assert "radius" in str(error.value) and "-1" in str(error.value)
    assert isinstance(error.value, ValueError)


def test_an_error_of_a_dict_names_the_key(ball):
    ball["bodies"][0]["mass"] = -2
    with pytest.raises(unibody.InputError, match=r"bodies\[0\]\.mass.*found -2") as error:
        unibody.Scene(ball)
    assert error.value.line is None


def test_what_no_scene_can_hold_is_named_by_its_place(ball):
    ball["bodies"][0]["mass"] = object()
    with pytest.raises(unibody.InputError, match=r"bodies\[0\]\.mass.*object"):
        unibody.Scene(ball)
    ball["bodies"] = ball
    with pytest.raises(unibody.InputError, match="levels"):
        unibody.Scene(ball)


def test_names_lead_to_ids():
    scene = unibody.Scene.load(str(SOURCE / "scenes" / "gripper.yaml"))
    assert scene.body_count == 64
    assert scene.ids("marble").tolist() == list(range(4, 64))
    assert scene.body_name(int(scene.ids("crate")[0])) == "crate"
    with pytest.raises(unibody.InputError, match="crane"):
        scene.ids("crane")
