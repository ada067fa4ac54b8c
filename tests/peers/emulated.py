"""The built program as an emulated rig, for the peers."""

import contextlib
import pathlib
import signal
import socket
import subprocess
import time


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


@contextlib.contextmanager
def rig(program, folder, *options):
    """Runs `hysteron rig emulate`; gives the device of the servos and the port of the tracker. It must end well."""
    device = pathlib.Path(folder) / "servos"
    port = free_port()
    command = [program, "rig", "emulate", "--dir", folder, "--port-tracker", str(port), *options]
    started = time.monotonic()
    emulator = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        while not device.exists():
            assert emulator.poll() is None and time.monotonic() < started + 10, "no port"
            time.sleep(0.01)
        yield str(device), port, started
    finally:
        emulator.send_signal(signal.SIGTERM)
        code = emulator.wait(10)
    assert code == 0, code
    assert not device.is_symlink(), "the link stayed"
