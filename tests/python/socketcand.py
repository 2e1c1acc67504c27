"""Sits on a simulated bus with python-can, through `devicenet simulate --serve`.

Usage: socketcand.py HOST PORT

The bus has a DeviceNet node with MAC ID 10, on line by Quick Connect; `dark` is a way onto it that has no power. Exits 0 when
everything was as expected. The last thing that is sent is a remote frame, 321 with a length of 2.
"""

import sys

import can

DUP_MAC_10 = 0x457
REQUEST = [0x00, 0x99, 0x99, 0x01, 0x00, 0x00, 0x00]
RESPONSE = [0x80, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]


def connect(port: int, host: str, channel: str = "can0") -> can.BusABC:
    return can.Bus(interface="socketcand", host=host, port=port, channel=channel)


def receive(bus: can.BusABC, wanted) -> can.Message:
    """The first frame that is wanted; others may come before it."""
    for _ in range(1000):
        message = bus.recv(timeout=20.0)
        assert message is not None, "nothing came in 20 s"
        if not message.is_error_frame and wanted(message):
            return message
    raise AssertionError("not among 1000 frames")


def main() -> None:
    host, port = sys.argv[1], int(sys.argv[2])
    with connect(port, host) as bus, connect(port, host) as other:
        # A frame of one client goes over the bus, and to the other client.
        bus.send(can.Message(arbitration_id=0x18FEF1FE, is_extended_id=True, data=[1, 2, 0xFF]))
        seen = receive(other, lambda m: m.arbitration_id == 0x18FEF1FE)
        assert seen.is_extended_id and list(seen.data) == [1, 2, 0xFF], seen

        # The node defends its MAC ID: a duplicate MAC ID check request is answered.
        bus.send(can.Message(arbitration_id=DUP_MAC_10, is_extended_id=False, data=REQUEST))
        answer = receive(bus, lambda m: m.arbitration_id == DUP_MAC_10 and m.data[0] & 0x80)
        assert list(answer.data) == RESPONSE, answer

        # The other client has seen both, in this order, at times that the bus allows.
        request = receive(other, lambda m: m.arbitration_id == DUP_MAC_10 and list(m.data) == REQUEST)
        reply = receive(other, lambda m: m.arbitration_id == DUP_MAC_10 and m.data[0] & 0x80)
        assert reply.timestamp - request.timestamp >= 100 / 125_000, (request, reply)

        # What cannot be sent comes back as an error frame, which python-can understands.
        with connect(port, host, "dark") as dark:
            dark.send(can.Message(arbitration_id=0x123, is_extended_id=False, data=[1]))
            error = dark.recv(timeout=20.0)
            assert error is not None and error.is_error_frame and error.arbitration_id == 0x001, error

        bus.send(can.Message(arbitration_id=0x321, is_extended_id=False, is_remote_frame=True, dlc=2))
    print("python-can", can.__version__, "sat on the bus")


main()
