"""The tracker's messages against pyigtl, an independent implementation of OpenIGTLink: openigtlink_peer.py PROGRAM FOLDER.

pyigtl receives the poses of the emulated rig, which must be those of its robot, at rest and with a tendon wound; and
our client receives what pyigtl sends: values, names and time stamps must agree. The client is the example
`tracker_listen`, built beside the program. Needs the Dynamixel SDK too, to wind the tendon.
"""

import math
import pathlib
import subprocess
import sys
import time
import tomllib

import dynamixel_sdk
import dynamixel_sdk.port_handler
import emulated
import numpy as np
import pyigtl

# pyigtl and our code hold values as 32-bit floats [mm, -].
POSITION_MM = 2e-5 * 2
ROTATION = 1e-6
PRESET = pathlib.Path(__file__).parents[2] / "rig/virtual/presets/mild.toml"
OPERATING_MODE, TORQUE, P_GAIN, GOAL, PRESENT = 11, 64, 84, 116, 132
# The servo that is wound, and the way it winds.
SERVO, WINDS = 1, 1


def rotation(qw, qx, qy, qz):
    """Rotation matrix of a unit quaternion."""
    return np.array([
        [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
        [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
        [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)],
    ])


def numbers(line):
    return [float(word) for word in line.split(",")[:9]]


def turned(vector_deg):
    """Rotation matrix of a rotation vector."""
    vector = np.radians(vector_deg)
    angle = np.linalg.norm(vector)
    half = math.sin(angle / 2) * vector / angle
    return rotation(math.cos(angle / 2), *half)


def poses(client, seconds):
    """Matrices and time stamps that arrive, without repetitions."""
    received = {}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        message = client.wait_for_message("Tip", timeout=0.2)
        if message is not None:
            assert message.message_type == "TRANSFORM", message.message_type
            received[message.timestamp] = message.matrix
    return received


def wind(device, ticks):
    """Winds the tendon by so much."""
    # A machine with other work to do answers late now and then [ms].
    dynamixel_sdk.port_handler.LATENCY_TIMER = 250
    port, handler = dynamixel_sdk.PortHandler(device), dynamixel_sdk.PacketHandler(2.0)
    assert port.openPort() and port.setBaudRate(1_000_000)
    for address, size, value in [(OPERATING_MODE, 1, 4), (P_GAIN, 2, 1600), (TORQUE, 1, 1)]:
        call = {1: handler.write1ByteTxRx, 2: handler.write2ByteTxRx}[size]
        assert call(port, SERVO, address, value) == (0, 0), address
    present, result, error = handler.read4ByteTxRx(port, SERVO, PRESENT)
    assert (result, error) == (0, 0)
    assert handler.write4ByteTxRx(port, SERVO, GOAL, (present + WINDS * ticks) % (1 << 32)) == (0, 0)
    port.closePort()


def pyigtl_receives(program, folder):
    """Our emulated rig, their client. Returns the number of poses, and how far the tip went [mm]."""
    robot = tomllib.loads(PRESET.read_text())
    origin = np.array(robot["tracker"]["robot_position_mm"])
    axes = turned(robot["tracker"]["robot_rotation_deg"])
    with emulated.rig(program, folder, "--robot", PRESET) as (device, port, _):
        client = pyigtl.OpenIGTLinkClient(host="127.0.0.1", port=port)
        at_rest = poses(client, 2.0)
        wind(device, 350)
        time.sleep(1.0)
        bent = poses(client, 2.0)
        client.stop()
    for received in [at_rest, bent]:
        stamps = np.array(sorted(received))
        # The tracker loses some poses, and pyigtl keeps the latest message only.
        assert 0.5 * 2.0 * robot["tracker"]["rate_hz"] < len(stamps), len(stamps)
        assert (np.diff(stamps) > 0.5 / robot["tracker"]["rate_hz"]).all(), np.diff(stamps).min()
        for matrix in received.values():
            assert np.abs(matrix[:3, :3].T @ matrix[:3, :3] - np.eye(3)).max() < ROTATION, matrix
            assert np.linalg.det(matrix[:3, :3]) > 0, matrix
    # In the robot's frame: the tip of an upright rod, which leans to where it went.
    def in_robot(received):
        mean = np.mean(list(received.values()), axis=0)
        return axes.T @ (mean[:3, 3] - origin), axes.T @ mean[:3, 2]

    (rest, up), (tip, direction) = in_robot(at_rest), in_robot(bent)
    length = robot["body"]["length_mm"]
    assert np.linalg.norm(rest - [0, 0, length]) < 0.05 * length, rest
    assert up[2] > 0.99, up
    went = (tip - rest)[:2]
    leaned = (direction - up)[:2]
    assert np.linalg.norm(went) > 3, went
    assert went @ leaned > 0.9 * np.linalg.norm(went) * np.linalg.norm(leaned), (went, leaned)
    # To the side of the tendon that is wound.
    angle = math.radians(robot["tendons"]["angles_deg"][SERVO - 1])
    assert went @ [math.cos(angle), math.sin(angle)] > 0.9 * np.linalg.norm(went), went
    return len(at_rest) + len(bent), np.linalg.norm(went)


def pose(k):
    """Position [mm] and quaternion w, x, y, z of pose k."""
    angle = 0.05 * k
    q = np.array([math.cos(angle), math.sin(angle), 0.3, -0.2])
    return [30 * math.sin(angle), 0.1 * k, 250 - 0.01 * k], q / np.linalg.norm(q)


def ours_receives(program, version):
    """Their server, our client. Returns the number of poses compared and the spread of their times [ms]."""
    port = emulated.free_port()
    server = pyigtl.OpenIGTLinkServer(port=port, local_server=True)
    listen = pathlib.Path(program).parent / "examples/tracker_listen"
    command = [listen, f"127.0.0.1:{port}", "Probe", "6"]
    listener = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    while not server.is_connected():
        time.sleep(0.01)
    sent = {}
    for k in range(160):
        position, q = pose(k)
        matrix = np.eye(4)
        matrix[:3, :3] = rotation(*q)
        matrix[:3, 3] = position
        stamp = time.time()
        message = pyigtl.TransformMessage(matrix, device_name="Probe", timestamp=stamp)
        message.header_version = version
        flagged = version > 1 and k % 10 == 9
        if version > 1:
            message.metadata = {"ProbeTransformStatus": "MISSING" if flagged else "OK"}
        sent[k] = (stamp, flagged)
        server.send_message(message, wait=True)
        if k == 20:
            text = pyigtl.StringMessage("not for us", device_name="Probe")
            server.send_message(text, wait=True)
        time.sleep(0.02)
    output, _ = listener.communicate(timeout=30)
    server.stop()
    rows = [line for line in output.splitlines() if line[0].isdigit()]
    offsets = []
    for line in rows:
        now, host, x, y, z, *q = numbers(line)
        k = round(y / 0.1)
        stamp, flagged = sent.pop(k)
        position, expected = pose(k)
        assert np.abs(np.subtract([x, y, z], position)).max() < POSITION_MM, (k, line)
        assert 1 - abs(np.dot(q, expected)) < ROTATION, (k, line)
        assert line.endswith("Flagged" if flagged else "Good"), (k, line)
        assert host <= now
        offsets.append(host - stamp)
    assert len(rows) >= 150, output
    assert "damaged: 0" in output and "skipped: 1," in output, output
    # Both clocks run at one rate here: the offset is the same but for what the fastest message was late.
    spread = 1e3 * np.ptp(offsets[20:])
    assert spread < 5, f"times spread by {spread} ms"
    return len(rows), spread


def ours_names(program):
    """Their server sends what cannot be a pose, our client names it. Returns the number of kinds."""
    zeros, mirrored = np.zeros((4, 4)), np.diag([1.0, 1.0, -1.0, 1.0])
    kinds = [(zeros, "a matrix of zeros"), (np.eye(4), "the identity, to the last bit"), (mirrored, "mirrored")]
    for matrix, named in kinds:
        port = emulated.free_port()
        server = pyigtl.OpenIGTLinkServer(port=port, local_server=True)
        listen = pathlib.Path(program).parent / "examples/tracker_listen"
        command = [listen, f"127.0.0.1:{port}", "Probe", "2"]
        listener = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        while not server.is_connected():
            time.sleep(0.01)
        for _ in range(20):
            message = pyigtl.TransformMessage(matrix, device_name="Probe", timestamp=time.time())
            server.send_message(message, wait=True)
            time.sleep(0.02)
        output, _ = listener.communicate(timeout=30)
        server.stop()
        rows = [line for line in output.splitlines() if line[0].isdigit()]
        assert rows and all(line.endswith("Flagged") for line in rows), output
        assert named in output, output
    return len(kinds)


def main(program, folder):
    n, went = pyigtl_receives(program, folder)
    print(f"  pyigtl receives {n} poses of a robot whose tip goes {went:.1f} mm", flush=True)
    for version in [1, 2]:
        n, spread = ours_receives(program, version)
        print(f"  ours receives header version {version}: {n} poses agree, times spread by {spread:.3f} ms", flush=True)
    print(f"  ours names {ours_names(program)} kinds of what is no pose", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
