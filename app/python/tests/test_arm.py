"""Arms against closed forms."""

from __future__ import annotations

import numpy as np
import pyhysteron as ph
import pytest

GRAVITY = 9.81
MASS, LENGTH, INERTIA = 2.0, 0.7, 0.03

PENDULUM = f"""<mujoco><option gravity="0 0 -{GRAVITY}"/><worldbody><body name="rod">
<joint name="hinge" type="hinge" axis="0 1 0"/>
<inertial pos="0 0 -{LENGTH}" mass="{MASS}" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
</body></worldbody></mujoco>"""


@pytest.fixture
def pendulum(tmp_path):
    path = tmp_path / "pendulum.xml"
    path.write_text(PENDULUM)
    return ph.Arm.read(path)


@pytest.fixture
def states():
    draw = np.random.default_rng(5)
    return [draw.uniform(-2.0, 2.0, (1000, 1)) for _ in range(3)]


def test_a_pendulum_follows_its_equation(pendulum, states):
    q, qd, qdd = states
    assert (pendulum.n_joints, pendulum.joint_names) == (1, ["hinge"])
    inertia = MASS * LENGTH**2 + INERTIA
    expected = inertia * qdd + MASS * GRAVITY * LENGTH * np.sin(q)
    tau = pendulum.rnea(q, qd, qdd)
    # Sums of numbers below 20 in double precision.
    np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(pendulum.forward_dynamics(q, qd, tau), qdd, rtol=0, atol=1e-12)
    mass = pendulum.mass_matrix(q)
    assert mass.shape == (1000, 1, 1)
    np.testing.assert_allclose(mass, inertia, rtol=1e-14)


def test_a_single_row_is_one_of_many(pendulum, states):
    q, qd, qdd = states
    one = pendulum.rnea(q[3], qd[3], qdd[3])
    assert one.shape == (1,)
    np.testing.assert_array_equal(one, pendulum.rnea(q, qd, qdd)[3])
    assert pendulum.mass_matrix(q[3]).shape == (1, 1)
    # Any numbers, any order in memory.
    integers = pendulum.rnea([[1], [2]], [[0], [0]], [[0], [0]])
    np.testing.assert_array_equal(integers, pendulum.rnea(*(np.array([[1.0], [2.0]]) * k for k in (1, 0, 0))))


def test_forward_undoes_inverse_dynamics_of_the_panda():
    panda = ph.Arm.read("panda")
    draw = np.random.default_rng(1)
    q, qd, qdd = draw.uniform(-0.5, 0.5, (3, 64, panda.n_joints))
    tau = panda.rnea(np.asfortranarray(q), qd[::1], qdd)
    # Fingers of 15 g next to an arm of 18 kg.
    np.testing.assert_allclose(panda.forward_dynamics(q, qd, tau), qdd, atol=1e-9)
    zero = np.zeros_like(q)
    product = np.einsum("nij,nj->ni", panda.mass_matrix(q), qdd)
    np.testing.assert_allclose(product, panda.rnea(q, zero, qdd) - panda.rnea(q, zero, zero), atol=1e-12)
    position, rotation = panda.frame_pose(q)
    assert position.shape == (64, 3)
    np.testing.assert_allclose(rotation @ rotation.transpose(0, 2, 1), np.tile(np.eye(3), (64, 1, 1)), atol=1e-14)


def test_bad_arms_and_states_are_refused(pendulum):
    with pytest.raises(ph.BadInput):
        ph.Arm.read("none")
    with pytest.raises(ph.BadInput, match="qd: expected 2 rows, as q has, got 3 rows"):
        pendulum.rnea(np.zeros((2, 1)), np.zeros((3, 1)), np.zeros((2, 1)))
    with pytest.raises(ph.BadInput, match="q: expected an array n × 1, or 1 numbers, got shape 2 × 2"):
        pendulum.mass_matrix(np.zeros((2, 2)))
