"""Checks the tracker's messages against pyigtl, an independent implementation of OpenIGTLink.

pyigtl receives what our server sends, and our client receives what pyigtl sends; values, names and time stamps must
agree. Usage: openigtlink_peer.py --program target/release/hysteron --examples target/release/examples
Needs pyigtl 0.3.4 and numpy. Exit code 0 if everything agrees.
"""

import argparse
import math
import pathlib
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pyigtl

# pyigtl and our code hold values as 32-bit floats [mm, -].
POSITION_MM = 2e-5 * 2
ROTATION = 1e-6
# pyigtl cuts a time stamp to nanoseconds, we to 2^-32 s; a double of this century resolves 0.24 us.
STAMP_S = 1e-6


def rotation(qw, qx, qy, qz):
    """Rotation matrix of a unit quaternion."""
    return np.array([
        [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
        [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
        [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)],
    ])


def numbers(line):
    return [float(word) for word in line.split(",")[:9]]


def pyigtl_receives(examples, kind):
    """Our pose server, their client. Returns the number of poses compared."""
    command = [examples / "pose_server", "0", "Tip", kind, "4"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    port = int(server.stdout.readline().rsplit(":", 1)[1])
    client = pyigtl.OpenIGTLinkClient(host="127.0.0.1", port=port)
    received = {}
    lines = []
    reader = threading.Thread(target=lambda: lines.extend(server.stdout))
    reader.start()
    while server.poll() is None:
        message = client.wait_for_message("Tip", timeout=0.2)
        if message is not None:
            received[round(message.timestamp, 3)] = message
    client.stop()
    reader.join()
    sent = [numbers(line) for line in lines if line[0].isdigit()]
    n = 0
    for stamp, x, y, z, *q in sent:
        message = received.pop(round(stamp, 3), None)
        if message is None:
            continue
        n += 1
        assert abs(message.timestamp - stamp) < STAMP_S, (message.timestamp, stamp)
        assert message.message_type == "TRANSFORM", message.message_type
        assert np.abs(message.matrix[:3, 3] - [x, y, z]).max() < POSITION_MM, message
        assert np.abs(message.matrix[:3, :3] - rotation(*q)).max() < ROTATION, message
        expected = {"TipTransformStatus": "OK"} if kind == "status" else {}
        assert message.metadata == expected, message.metadata
    assert not received, f"never sent: {received}"
    # pyigtl keeps the latest message only, so a few may be missed; those before it connected are.
    assert n > 100, f"{n} of {len(sent)} poses"
    return n


def pose(k):
    """Position [mm] and quaternion w, x, y, z of pose k."""
    angle = 0.05 * k
    q = np.array([math.cos(angle), math.sin(angle), 0.3, -0.2])
    return [30 * math.sin(angle), 0.1 * k, 250 - 0.01 * k], q / np.linalg.norm(q)


def ours_receives(examples, version):
    """Their server, our client. Returns the number of poses compared and the spread of their times [ms]."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = pyigtl.OpenIGTLinkServer(port=port, local_server=True)
    command = [examples / "tracker_listen", f"127.0.0.1:{port}", "Probe", "6"]
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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", help="the program hysteron; not needed here")
    parser.add_argument("--examples", type=pathlib.Path, required=True, help="folder of the built examples")
    examples = parser.parse_args().examples
    for kind in ["transform", "status"]:
        print(f"pyigtl receives {kind}: {pyigtl_receives(examples, kind)} poses agree")
    for version in [1, 2]:
        n, spread = ours_receives(examples, version)
        print(f"ours receives header version {version}: {n} poses agree, times spread by {spread:.3f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
