"""Steps, states and what acts on bodies, against closed forms and the program."""
import ctypes
import gc
import os
import signal
import threading

import numpy as np
import pytest

import unibody
from conftest import SOURCE, mpirun, PROGRAM

SCENES = SOURCE / "scenes"


def test_the_states_are_those_of_the_program(state_of_program):
    for name, frames in [("boxes_500", 10), ("carousel", 15), ("cloth_hanging", 8), ("silo_gate", 6)]:
        scene = unibody.Scene.load(str(SCENES / f"{name}.yaml"))
        with unibody.Simulation(scene) as simulation:
            simulation.step(frames * scene.substeps)
            assert simulation.state_hash() == state_of_program(SCENES / f"{name}.yaml", "-set", f"time.frames={frames}"), name


def test_a_free_body_goes_straight_on(ball):
    ball["bodies"][0].update(velocity=[1, -2, 0.5], angular_velocity=[0, 0, 3])
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.step(50)
        assert simulation.time == pytest.approx(0.5, rel=1e-14)
        assert simulation.steps_done == 50
        np.testing.assert_allclose(simulation.positions, [[0.5, -1, 0.25]], rtol=1e-12)
        np.testing.assert_allclose(simulation.velocities, [[1, -2, 0.5]], rtol=1e-14)
        np.testing.assert_allclose(simulation.angular_velocities, [[0, 0, 3]], rtol=1e-12)
        w, x, y, z = simulation.orientations[0]
        # A step turns it by Cayley's map of 3 rad/s over 0.01 s.
        assert 2 * np.arctan2(z, w) == pytest.approx(50 * 2 * np.arctan(0.015), rel=1e-12)
        assert (x, y) == (0, 0)


def test_a_force_acts_for_one_step(ball):
    """F h / m of velocity, T h / I of spin: 2 kg, I = 2/5 m r^2 = 0.2 kg m^2, h = 0.01 s."""
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.apply_force(0, [10, 0, -4], torque=[0, 2, 0])
        for _ in range(2):
            simulation.step()
            np.testing.assert_allclose(simulation.velocities, [[0.05, 0, -0.02]], rtol=1e-13)
            np.testing.assert_allclose(simulation.angular_velocities, [[0, 0.1, 0]], rtol=1e-13, atol=1e-16)


def test_a_torque_on_a_box_goes_by_its_own_axes(ball):
    """A box 1 x 2 x 3 of 6 kg, turned by 90 degrees about z: a torque along the world's x turns it about its own y,
    I_y = 6 (1 + 9) / 12 = 5 kg m^2."""
    ball["bodies"][0] = {"shape": {"box": {"size": [1, 2, 3]}}, "mass": 6,
                         "orientation": {"axis": [0, 0, 1], "angle": 90}}
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.apply_force([0], torque=[5, 0, 0])
        simulation.step()
        np.testing.assert_allclose(simulation.angular_velocities, [[0.01, 0, 0]], rtol=1e-9, atol=1e-12)


def test_a_force_of_the_weight_holds_a_body(ball):
    ball["gravity"] = [0, 0, -9.81]
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        for _ in range(100):
            simulation.apply_force(0, [0, 0, 2 * 9.81])
            simulation.step()
        np.testing.assert_allclose(simulation.positions, [[0, 0, 0]], atol=1e-14)


def test_velocities_can_be_set(ball):
    ball["bodies"].append({"name": "other", "shape": {"sphere": {"radius": 0.5}}, "mass": 1, "position": [10, 0, 0]})
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.set_velocity([0, 1], [[1, 0, 0], [0, 2, 0]], angular_velocity=[0, 0, 1])
        simulation.step(10)
        np.testing.assert_allclose(simulation.positions, [[0.1, 0, 0], [10, 0.2, 0]], rtol=1e-12)
        np.testing.assert_allclose(simulation.angular_velocities, [[0, 0, 1], [0, 0, 1]], rtol=1e-12)


def test_contacts_follow_a_velocity_that_was_set(ball):
    """A ball that flies 50 of its diameters in a step meets a wall between: it is stopped there, at -0.5 m."""
    ball["bodies"].append({"shape": {"box": {"size": [0.2, 9, 9]}}, "motion": "fixed", "position": [20.1, 0, 0]})
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.step()
        simulation.set_velocity(0, [5000, 0, 0])
        simulation.step()
        assert simulation.positions[0, 0] == pytest.approx(19.5, abs=1e-3)


def test_a_kinematic_body_goes_as_told(ball):
    del ball["bodies"][0]["mass"]
    ball["bodies"][0]["motion"] = "kinematic"
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.set_velocity(0, [0, 0, 1])
        simulation.step(20)
        simulation.set_velocity(0, [0, 0, -0.5])
        simulation.step(20)
        np.testing.assert_allclose(simulation.positions, [[0, 0, 0.1]], atol=1e-13)


def test_a_motor_turns_as_fast_as_it_is_set():
    scene = unibody.Scene({
        "time": {"frame": 0.01}, "gravity": [0, 0, 0],
        "bodies": [{"name": "rotor", "shape": {"box": {"size": [1, 1, 0.2]}}, "mass": 1, "position": [0, 0, 0]}],
        "joints": [{"type": "hinge", "bodies": ["rotor", "world"], "anchor": [0, 0, 0], "axis": [0, 0, 1],
                    "motor": {"speed": 0, "max_torque": 1000}}]})
    with unibody.Simulation(scene) as simulation:
        assert simulation.joints()["coordinate"][0] == 0  # before the first step, too
        for speed in (2, -1.5, 0):
            simulation.set_motor(0, speed)
            simulation.step(5)
            assert simulation.angular_velocities[0, 2] == pytest.approx(speed, abs=1e-4)
        assert simulation.joints().shape == (1,)
        assert simulation.joints()["coordinate"][0] == pytest.approx(0.5 * 0.05, abs=1e-5)  # (2 - 1.5) rad/s, 0.05 s each


def test_a_spring_turns_a_robot_of_a_file(tmp_path):
    (tmp_path / "arm.urdf").write_text(
        '<robot name="arm"><link name="base"/><link name="rod"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
        '<joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/><dynamics damping="0.5"/></joint></robot>')
    (tmp_path / "scene.yaml").write_text("{time: {frame: 0.01}, bodies: [{name: r, urdf: {file: arm.urdf, joints: [{name: pivot, at: 30}]}}]}")
    scene = unibody.Scene.load(str(tmp_path / "scene.yaml"))
    assert scene.joint_names == {"r/pivot": [0]}
    with unibody.Simulation(scene) as simulation:
        assert simulation.joints()["coordinate"][0] == pytest.approx(np.pi / 6, abs=1e-12)
        simulation.set_velocity(1, [0, 0, 0], [0, 0, 3])
        simulation.step(10)
        after = 3 / (1 + 0.01 * 0.5) ** 10  # by implicit Euler of I w' = -c w, with I = 1 kg m^2
        assert simulation.angular_velocities[1, 2] == pytest.approx(after, rel=1e-5)
        assert simulation.joints()["spring"][0] == pytest.approx(-0.5 * after, rel=1e-5)


def test_bonds_that_break(tmp_path):
    balls = [{"name": name, "shape": {"sphere": {"radius": 0.1}}, "position": [0, 0, z], **more}
             for name, z, more in (("top", 0, {"motion": "fixed"}), ("middle", -0.2, {"mass": 1}), ("bottom", -0.4, {"mass": 1}))]
    scene = unibody.Scene({"time": {"frame": 0.005}, "bodies": balls,
                           "bonds": [{"bodies": ["top", "middle", "bottom"], "name": "glue", "strength": {"tension": 15}}]})
    assert scene.joint_names == {"glue": [0, 1]}
    with unibody.Simulation(scene) as simulation:
        assert not simulation.joints()["broken"].any()
        simulation.step(40)  # 2 kg, 19.6 N, hang from the first bond; once it has broken, nothing hangs from the second
        assert simulation.joints()["broken"].tolist() == [True, False]
        simulation.checkpoint(str(tmp_path / "c.h5"))
        simulation.step(10)
        end = simulation.state_hash()
        simulation.restore(str(tmp_path / "c.h5"))
        assert simulation.joints()["broken"].tolist() == [True, False]
        simulation.step(10)
        assert simulation.state_hash() == end


def test_a_box_at_rest_has_four_contacts():
    scene = unibody.Scene({"bodies": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}},
                                      {"shape": {"box": {"size": [1, 1, 1]}}, "density": 1000, "position": [0, 0, 0.5]}]})
    with unibody.Simulation(scene) as simulation:
        simulation.step(10)
        contacts = simulation.contacts()
        assert len(contacts) == 4
        assert set(contacts["body_a"]) == {0} and set(contacts["body_b"]) == {1}
        np.testing.assert_allclose(contacts["normal"], [[0, 0, -1]] * 4, atol=1e-9)
        np.testing.assert_allclose(sorted(map(tuple, np.round(contacts["point"][:, :2], 3))),
                                   [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)])
        assert np.abs(contacts["gap"]).max() < 1e-3
        measures = simulation.measures()
        assert measures["contacts"] == 4 and measures["contact_pairs"] == 1
        assert measures["potential_energy"] == pytest.approx(1000 * 9.81 * 0.5, rel=1e-3)


def test_a_flow_is_counted(ball):
    ball["probes"] = [{"name": "gate", "flow": {"point": [1, 0, 0], "normal": [1, 0, 0]}},
                      {"name": "room", "box": {"low": [-1, -1, -1], "high": [1, 1, 1]}}]
    ball["bodies"][0]["velocity"] = [10, 0, 0]
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        assert simulation.probe("gate")["count (1)"] == 0
        assert simulation.probe("room")["count (1)"] == 1
        simulation.step(25)  # to 2.5 m, through the gate at 1 m
        assert simulation.probe("gate")["count (1)"] == 1
        assert simulation.probe("gate")["mass (kg)"] == 2
        assert simulation.probe("room")["count (1)"] == 0
        with pytest.raises(unibody.InputError, match="gate, room"):
            simulation.probe("door")


def test_forces_are_what_changes_momentum(ball):
    ball["bodies"] = [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}},
                      {"name": "ball", "shape": {"sphere": {"radius": 0.1}}, "mass": 2, "position": [0, 0, 0.15], "velocity": [1, 0, -2]}]
    ball["gravity"] = [0, 0, -10]
    ball["probes"] = [{"name": "floor", "force": {"on": "floor"}}]
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        assert np.isnan(simulation.probe("floor")["force_z (N)"])
        pushed = 0
        for _ in range(20):
            before = 2 * simulation.velocities[1]
            simulation.step()
            force = (2 * simulation.velocities[1] - before) / simulation.step_length - [0, 0, -20]
            contacts = simulation.contact_forces()
            pushed += len(contacts)
            np.testing.assert_allclose(-contacts["force"].sum(axis=0), force, atol=1e-9)  # on the floor, which is the first side
            told = simulation.probe("floor")
            np.testing.assert_allclose([told[f"force_{axis} (N)"] for axis in "xyz"], -force, atol=1e-9)
            if len(contacts) > 0:
                assert contacts["bodies"][0].tolist() == [0, 1, -1, -1] and contacts["shares"][0].tolist() == [1, -1, 0, 0]
        assert pushed > 10


def test_the_report_has_a_row_a_step(ball):
    with unibody.Simulation(unibody.Scene(ball, set={"time.substeps": 4})) as simulation:
        simulation.step(6)
        report = simulation.report
        assert report["step"].tolist() == [1, 2, 3, 4, 5, 6]
        np.testing.assert_allclose(report["time"], 0.0025 * np.arange(1, 7), rtol=1e-14)
        assert report["converged"].all()


def test_a_checkpoint_is_the_state(tmp_path, state_of_program):
    path = str(SCENES / "carousel.yaml")
    scene = unibody.Scene.load(path)
    file = str(tmp_path / "checkpoint.h5")
    with unibody.Simulation(scene) as simulation:
        simulation.step(8 * scene.substeps)
        simulation.checkpoint(file)
        simulation.step(7 * scene.substeps)
        end = simulation.state_hash()
        simulation.restore(file)
        assert simulation.steps_done == 8 * scene.substeps
        simulation.step(7 * scene.substeps)
        assert simulation.state_hash() == end
    with unibody.Simulation(scene, checkpoint=file) as simulation:
        simulation.step(7 * scene.substeps)
        assert simulation.state_hash() == end
    assert state_of_program(path, "-restart", file, "-set", "time.frames=15") == end


def test_a_checkpoint_of_another_scene_changes_nothing(tmp_path, ball):
    file = str(tmp_path / "checkpoint.h5")
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.checkpoint(file)
    with unibody.Simulation(unibody.Scene(ball, set={"bodies[0].mass": 3})) as simulation:
        simulation.step(3)
        before = simulation.state_hash()
        with pytest.raises(unibody.InputError, match="another"):
            simulation.restore(file)
        assert simulation.state_hash() == before
        simulation.step()


def test_another_scene_goes_on_with_the_bodies_of_a_checkpoint(tmp_path, ball):
    file = str(tmp_path / "checkpoint.h5")
    ball["bodies"][0].update(velocity=[1, -2, 0.5], angular_velocity=[0, 0, 3])
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.step(4)
        simulation.checkpoint(file)
        positions, velocities = simulation.positions[0], simulation.velocities[0]
    scene = unibody.Scene(ball, set={"bodies[0].mass": 3})
    with unibody.Simulation(scene, continue_from=file) as simulation:
        assert simulation.time == 0
        assert (simulation.positions[0] == positions).all() and (simulation.velocities[0] == velocities).all()
    with pytest.raises(unibody.InputError, match="expected one of them"):
        unibody.Simulation(scene, checkpoint=file, continue_from=file)


def test_within_a_frame_there_is_no_checkpoint(tmp_path, ball):
    with unibody.Simulation(unibody.Scene(ball, set={"time.substeps": 4})) as simulation:
        simulation.step(6)
        with pytest.raises(unibody.InputError, match="end of a frame"):
            simulation.checkpoint(str(tmp_path / "checkpoint.h5"))


@pytest.mark.parametrize("call, message", [
    (lambda s: s.set_velocity(7, [0, 0, 0]), "found body 7, expected an id from 0 to 1"),
    (lambda s: s.set_velocity(-1, [0, 0, 0]), "found body -1"),
    (lambda s: s.set_velocity(1, [0, 0, 0]), r"found body 1 \(floor\), which is fixed"),
    (lambda s: s.apply_force(1, [0, 0, 0]), r"found body 1 \(floor\), which no force moves"),
    (lambda s: s.set_velocity(0, [0, 0]), r"velocity: found another shape, expected \(3,\) or \(1, 3\)"),
    (lambda s: s.set_velocity([0, 0], [[0, 0, 0]]), r"expected \(3,\) or \(2, 3\)"),
    (lambda s: s.set_velocity(0, [0, 0, float("nan")]), "found nan, expected finite"),
    (lambda s: s.apply_force(0, torque=[0, float("inf"), 0]), "found inf, expected finite"),
    (lambda s: s.set_velocity("ball", [0, 0, 0]), "ids: found no whole number"),
    (lambda s: s.set_motor(0, 1), "found joint 0, expected none"),
    (lambda s: s.step(-1), "found -1 steps"),
    (lambda s: s.home("colours"), "found field 'colours'"),
    (lambda s: s.probe("door"), "the scene has no probes"),
])
def test_wrong_arguments_change_nothing(ball, call, message):
    ball["bodies"].append({"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "position": [0, 0, -3]})
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        before = simulation.state_hash()
        with pytest.raises(unibody.InputError, match=message):
            call(simulation)
        assert simulation.state_hash() == before


def test_a_motion_out_of_the_plane_is_refused(ball):
    ball["planar"] = True
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        with pytest.raises(unibody.InputError, match="planar"):
            simulation.set_velocity(0, [0, 1, 0])
        with pytest.raises(unibody.InputError, match="planar"):
            simulation.apply_force(0, torque=[1, 0, 0])
        simulation.set_velocity(0, [1, 0, 1], angular_velocity=[0, 1, 0])


def test_a_communicator_must_be_one(ball):
    with pytest.raises(unibody.InputError, match="comm: found an object of type int"):
        unibody.Simulation(unibody.Scene(ball), comm=3)


def test_a_state_that_cannot_be_stops_the_steps(ball):
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        simulation.apply_force(0, [1e300, 0, 0])
        with pytest.raises(unibody.RunError, match="ball"):
            simulation.step(3)


def test_a_closed_simulation_says_so(ball):
    simulation = unibody.Simulation(unibody.Scene(ball))
    simulation.close()
    simulation.close()
    with pytest.raises(unibody.InputError, match="closed"):
        simulation.step()


def test_ctrl_c_ends_the_steps(ball):
    with unibody.Simulation(unibody.Scene(ball)) as simulation:
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            simulation.step(10**9)
        timer.join()
        done = simulation.steps_done
        simulation.step()
        assert simulation.steps_done == done + 1


def test_other_threads_run_during_a_step():
    scene = unibody.Scene.load(str(SCENES / "boxes_500.yaml"))
    ended = threading.Event()
    counts = []

    def count():
        n = 0
        while not ended.wait(1e-4):
            n += 1
        counts.append(n)

    with unibody.Simulation(scene) as simulation:
        thread = threading.Thread(target=count)
        thread.start()
        simulation.step(20)
        ended.set()
        thread.join()
    assert counts[0] > 20  # some in each step


def resident_bytes():
    ctypes.CDLL(None).malloc_trim(0)
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_runs_one_after_another_leave_nothing_behind():
    """Spheres slide on a slope by friction: 20 runs in one process; from the fifth on the process stays as large as it is."""
    path = str(SCENES / "boxes_500.yaml")
    sizes = []
    for run in range(20):
        scene = unibody.Scene.load(path, set={"materials.box.friction": 0.05 * run})
        simulation = unibody.Simulation(scene)
        simulation.step(2)
        del simulation, scene
        gc.collect()
        sizes.append(resident_bytes())
    assert sizes[-1] - sizes[4] < 3e6, sizes  # one run holds some 10 MB


def test_what_is_left_open_ends_with_python(tmp_path):
    script = tmp_path / "open.py"
    script.write_text("import unibody\n"
                      "s = unibody.Simulation(unibody.Scene({'bodies': [{'mass': 1, 'shape': {'sphere': {'radius': 1}}}]}))\n"
                      "s.step(2)\n", encoding="utf-8")
    for ranks in (1, 2):
        ended = mpirun(ranks, os.sys.executable, script)
        assert (ended.returncode, ended.stderr) == (0, "")


def test_help_gives_units():
    assert "m/s" in unibody.Simulation.velocities.__doc__
    assert "N" in unibody.Simulation.apply_force.__doc__
    assert unibody.version().startswith("unibody ")
    assert os.path.exists(PROGRAM)


def test_bodies_that_come_and_go():
    scene = unibody.Scene({
        "time": {"frame": 0.01, "frames": 100},
        "bodies": [
            {"name": "late", "shape": {"sphere": {"radius": 0.1}}, "mass": 1, "start": "absent", "position": [5, 0, 0]},
            {"name": "rain", "density": 1000,
             "inlet": {"count": 20, "rate": 100, "box": {"low": [0, 0, 0], "high": [1, 1, 1]},
                       "mix": [{"shape": {"sphere": {"radius": 0.02}}}]}}],
        "events": [{"do": "add", "bodies": "late", "when": {"time": 0.05}}],
    })
    with unibody.Simulation(scene) as simulation:
        simulation.step(5)  # those that are due at 0, 0.01 ... 0.04 s
        there = np.isfinite(simulation.positions).all(axis=1)
        assert not there[0] and there[1:].sum() == 4
        assert np.isnan(simulation.velocities[~there]).all()
        simulation.step(1)
        assert np.isfinite(simulation.positions[0]).all()
        assert simulation.positions[0][2] == pytest.approx(-9.81 * 0.01 ** 2)


def test_events_by_a_column_need_a_report():
    scene = unibody.Scene({
        "bodies": [{"name": "a", "shape": {"sphere": {"radius": 0.1}}, "mass": 1, "start": "held"}],
        "events": [{"do": "release", "bodies": "a", "when": {"column": "kinetic_energy", "above": 1}}],
    })
    with pytest.raises(unibody.InputError, match="expected events at a time"):
        unibody.Simulation(scene)
