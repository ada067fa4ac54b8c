"""ROBOTIS's own SDK against the emulated servos: dynamixel_sdk_peer.py PROGRAM FOLDER.

Every check is a plain assertion; the exit code is 0 if all hold.
"""

import pathlib
import sys
import time

import dynamixel_sdk.port_handler
import emulated
from dynamixel_sdk import (
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    GroupBulkRead,
    GroupBulkWrite,
    GroupSyncRead,
    GroupSyncWrite,
    PacketHandler,
    PortHandler,
)

# A machine with other work to do answers late now and then [ms].
dynamixel_sdk.port_handler.LATENCY_TIMER = 250

IDS = [1, 2, 3, 4]
ID, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE, SECONDARY_ID, HOMING_OFFSET, SHUTDOWN = 7, 9, 10, 11, 12, 20, 63
STATUS_RETURN = 68
TORQUE, LED, HARDWARE_ERROR, I_GAIN, P_GAIN = 64, 65, 70, 82, 84
PROFILE_VELOCITY, GOAL, MOVING, LOAD, PRESENT = 112, 116, 122, 126, 132
MODEL = 1060
ALERT, RANGE, LIMIT, ACCESS = 0x80, 0x04, 0x06, 0x07
# Which way each servo of the preset winds its tendon.
WINDS = {1: 1, 2: -1, 3: -1, 4: 1}
# After everything else.
OVERLOAD_AT_S = 30.0
FAULTS = f"""
format = "hysteron-faults"
version = 1
[[fault]]
at_s = {OVERLOAD_AT_S}
kind = "overload"
servo = 4
"""


def signed(value):
    """The SDK reads without sign."""
    return value - (1 << 32) if value >= 1 << 31 else value


def little(value, size):
    return list(value.to_bytes(size, "little", signed=value < 0))


class Host:
    def __init__(self, device):
        self.port = PortHandler(device)
        assert self.port.openPort() and self.port.setBaudRate(1_000_000)
        self.handler = PacketHandler(2.0)

    def read(self, servo, address, size):
        call = {1: "read1ByteTxRx", 2: "read2ByteTxRx", 4: "read4ByteTxRx"}[size]
        value, result, error = getattr(self.handler, call)(self.port, servo, address)
        assert result == COMM_SUCCESS, (servo, address, self.handler.getTxRxResult(result))
        assert error == 0, (servo, address, error)
        return signed(value) if size == 4 else value

    def write(self, servo, address, size, value, expected=0):
        call = {1: "write1ByteTxRx", 2: "write2ByteTxRx", 4: "write4ByteTxRx"}[size]
        result, error = getattr(self.handler, call)(self.port, servo, address, value % (1 << 8 * size))
        assert result == COMM_SUCCESS, (servo, address, self.handler.getTxRxResult(result))
        assert error == expected, (servo, address, error)


def pings(host):
    for servo in IDS:
        model, result, error = host.handler.ping(host.port, servo)
        assert (model, result, error) == (MODEL, COMM_SUCCESS, 0), servo
    assert host.handler.ping(host.port, 9)[1] == COMM_RX_TIMEOUT
    found, result = host.handler.broadcastPing(host.port)
    assert result == COMM_SUCCESS and list(found) == IDS, found
    assert all(model == MODEL for model, _ in found.values())


def reads_and_writes(host):
    for address, size, value in [(RETURN_DELAY, 1, 0), (LED, 1, 1), (P_GAIN, 2, 700), (PROFILE_VELOCITY, 4, 200)]:
        host.write(1, address, size, value)
        assert host.read(1, address, size) == value
    # Bytes that look like a header come back stuffed, and the SDK takes that apart. (It does not stuff what it sends:
    # its addStuffing changes a copy. So they are written in two parts.) Indirect data that nobody directed holds any.
    data = [0xFF, 0xFF, 0xFD, 0x00, 0xFF, 0xFF]
    for address, part in [(634, data[:2]), (636, data[2:])]:
        assert host.handler.writeTxRx(host.port, 1, address, len(part), part) == (COMM_SUCCESS, 0)
    read, result, error = host.handler.readTxRx(host.port, 1, 634, len(data))
    assert (result, error, list(read)) == (COMM_SUCCESS, 0, data), read


def indirect(host):
    registers = [(PRESENT, 4), (MOVING, 1), (HARDWARE_ERROR, 1)]
    pointers = [byte for start, size in registers for k in range(size) for byte in little(start + k, 2)]
    for first_pointer, first_data in [(168, 224), (578, 634)]:
        result, error = host.handler.writeTxRx(host.port, 2, first_pointer, len(pointers), pointers)
        assert (result, error) == (COMM_SUCCESS, 0)
        read, result, error = host.handler.readTxRx(host.port, 2, first_data, 6)
        assert (result, error) == (COMM_SUCCESS, 0)
        assert signed(int.from_bytes(read[:4], "little")) == host.read(2, PRESENT, 4)
        # Through the detour a goal is written like any register.
        goal = [byte for k in range(4) for byte in little(PROFILE_VELOCITY + k, 2)]
        assert host.handler.writeTxRx(host.port, 2, first_pointer, len(goal), goal) == (COMM_SUCCESS, 0)
        host.write(2, first_data, 4, 123)
        assert host.read(2, PROFILE_VELOCITY, 4) == 123


def groups(host):
    write = GroupSyncWrite(host.port, host.handler, PROFILE_VELOCITY, 4)
    for servo in IDS:
        assert write.addParam(servo, little(100 + servo, 4))
    assert write.txPacket() == COMM_SUCCESS
    read = GroupSyncRead(host.port, host.handler, PROFILE_VELOCITY, 4)
    for servo in IDS:
        assert read.addParam(servo)
    for take in [read.txRxPacket, read.fastSyncRead]:
        assert take() == COMM_SUCCESS
        for servo in IDS:
            assert read.isAvailable(servo, PROFILE_VELOCITY, 4)
            assert read.getData(servo, PROFILE_VELOCITY, 4) == 100 + servo

    write = GroupBulkWrite(host.port, host.handler)
    assert write.addParam(1, LED, 1, [1])
    assert write.addParam(2, P_GAIN, 2, little(650, 2))
    assert write.addParam(3, PROFILE_VELOCITY, 4, little(77, 4))
    assert write.txPacket() == COMM_SUCCESS
    read = GroupBulkRead(host.port, host.handler)
    wanted = [(1, LED, 1, 1), (2, P_GAIN, 2, 650), (3, PROFILE_VELOCITY, 4, 77)]
    for servo, address, size, _ in wanted:
        assert read.addParam(servo, address, size)
    for take in [read.txRxPacket, read.fastBulkRead]:
        assert take() == COMM_SUCCESS
        for servo, address, size, value in wanted:
            assert read.getData(servo, address, size) == value, servo


def touched(host):
    """Registers that change what a tick means, or who obeys, do so: the driver must notice them."""
    before = host.read(1, PRESENT, 4)
    host.write(1, HOMING_OFFSET, 4, 200)
    assert abs(host.read(1, PRESENT, 4) - before - 200) <= 1
    host.write(1, HOMING_OFFSET, 4, 0)
    host.write(1, DRIVE_MODE, 1, 1)
    assert abs(host.read(1, PRESENT, 4) + before) <= 1
    host.write(1, DRIVE_MODE, 1, 0)
    # What is written to servo 1 reaches servo 2 as well, which does not answer.
    host.write(2, SECONDARY_ID, 1, 1)
    for servo in [1, 2]:
        host.write(servo, LED, 1, 0)
    host.write(1, LED, 1, 1)
    assert host.read(2, LED, 1) == 1
    host.write(2, SECONDARY_ID, 1, 255)
    # Level 1 answers reads alone, level 0 pings alone.
    host.write(3, STATUS_RETURN, 1, 1)
    assert host.handler.write1ByteTxRx(host.port, 3, LED, 1)[0] == COMM_RX_TIMEOUT
    assert host.read(3, LED, 1) == 1
    assert host.handler.write1ByteTxOnly(host.port, 3, STATUS_RETURN, 0) == COMM_SUCCESS
    assert host.handler.read1ByteTxRx(host.port, 3, LED)[1] == COMM_RX_TIMEOUT
    assert host.handler.ping(host.port, 3)[1] == COMM_SUCCESS
    assert host.handler.write1ByteTxOnly(host.port, 3, STATUS_RETURN, 2) == COMM_SUCCESS
    assert host.read(3, LED, 1) == 1


def answers(host, servo):
    """How many answers a question has, in what the line carries until it is silent."""
    assert host.handler.readTx(host.port, servo, PRESENT, 4) == COMM_SUCCESS
    time.sleep(0.3)
    heard = bytes(host.port.readPort(1000))
    host.port.is_using = False
    return heard.count(bytes([0xFF, 0xFF, 0xFD, 0x00]))


def one_id(host):
    """Two servos with one id. Where they wait for different times before they answer, their answers follow one another, and
    the SDK takes the first; where they wait alike, they lie on top of each other, and none comes through whole."""
    assert answers(host, 1) == 1
    for servo, delay, offset in [(1, 0, 0), (2, 250, 1365)]:
        host.write(servo, RETURN_DELAY, 1, delay)
        host.write(servo, HOMING_OFFSET, 4, offset)
    host.write(2, ID, 1, 1)
    # An answer takes 0.15 ms of the 0.5 ms by which one waits longer.
    assert answers(host, 1) == 2
    assert host.handler.write1ByteTxOnly(host.port, 1, RETURN_DELAY, 0) == COMM_SUCCESS
    time.sleep(0.3)
    results = [host.handler.read4ByteTxRx(host.port, 1, PRESENT)[1] for _ in range(3)]
    assert all(result != COMM_SUCCESS for result in results), results


def refusals(host):
    host.write(1, OPERATING_MODE, 1, 99, expected=RANGE)
    host.write(1, GOAL, 4, 5000, expected=LIMIT)
    host.write(1, PRESENT, 4, 0, expected=ACCESS)
    host.write(1, TORQUE, 1, 1)
    host.write(1, ID, 1, 9, expected=ACCESS)
    host.write(1, TORQUE, 1, 0)


def wait_at(host, servo, goal, ticks=10):
    seen = [host.read(servo, PRESENT, 4)]
    deadline = time.monotonic() + 10
    while abs(seen[-1] - goal) > ticks:
        assert time.monotonic() < deadline, (seen[-1], goal)
        seen.append(host.read(servo, PRESENT, 4))
    return seen


def mean_load(host, servo):
    """In the direction that winds the tendon, of a thousand."""
    time.sleep(0.3)
    loads = [host.read(servo, LOAD, 2) for _ in range(50)]
    return WINDS[servo] * sum(load - (1 << 16) * (load >> 15) for load in loads) / len(loads)


def winding(host):
    """A tendon that is wound pulls at its servo, one that is let out less; the position loop goes where it is told."""
    for servo in [3, 4]:
        host.write(servo, OPERATING_MODE, 1, 4)
        host.write(servo, P_GAIN, 2, 1600)
        host.write(servo, I_GAIN, 2, 200)
        host.write(servo, TORQUE, 1, 1)
        start = host.read(servo, PRESENT, 4)
        before = mean_load(host, servo)
        host.write(servo, GOAL, 4, start + WINDS[servo] * 400)
        assert len(set(wait_at(host, servo, start + WINDS[servo] * 400))) > 5, "it jumped"
        wound = mean_load(host, servo)
        host.write(servo, GOAL, 4, start)
        wait_at(host, servo, start)
        after = mean_load(host, servo)
        assert wound > 50 and wound > before + 50 and wound > after + 50, (servo, before, wound, after)
        host.write(servo, TORQUE, 1, 0)


def reboot(host):
    host.write(2, TORQUE, 1, 1)
    result, error = host.handler.reboot(host.port, 2)
    assert (result, error) == (COMM_SUCCESS, 0)
    time.sleep(0.5)
    assert host.read(2, TORQUE, 1) == 0
    assert host.read(2, P_GAIN, 2) == 640


def alert(host, started):
    host.write(4, TORQUE, 1, 1)
    time.sleep(max(0.0, started + OVERLOAD_AT_S + 0.3 - time.monotonic()))
    value, result, error = host.handler.read1ByteTxRx(host.port, 4, HARDWARE_ERROR)
    assert (value, result, error) == (1 << 5, COMM_SUCCESS, ALERT), (value, result, error)
    value, _, _ = host.handler.read1ByteTxRx(host.port, 4, TORQUE)
    assert value == 0
    host.handler.reboot(host.port, 4)
    time.sleep(0.5)
    assert host.read(4, HARDWARE_ERROR, 1) == 0


def main(program, folder):
    folder = pathlib.Path(folder)
    (folder / "faults.toml").write_text(FAULTS)
    with emulated.rig(program, folder, "--faults", folder / "faults.toml", "--preset", "mild") as (device, _, started):
        host = Host(device)
        for check in [pings, reads_and_writes, indirect, groups, touched, refusals, winding, reboot]:
            check(host)
            print(f"  {check.__name__}", flush=True)
        alert(host, started)
        print("  alert", flush=True)
        one_id(host)
        print("  one_id", flush=True)
        host.port.closePort()


if __name__ == "__main__":
    main(*sys.argv[1:])
