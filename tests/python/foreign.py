"""Is on a bus with `devicenet slave` and `devicenet get`, by python-can on SocketCAN: a client, a tool, and two devices.

Usage: foreign.py INTERFACE LOG

The slave `gauge` of cli/tests/live/line.toml, MAC ID 11, is on line when this begins. What is to be started next is said on standard
output. Every frame is written to LOG, which python-can does in the format of candump. Exits 0 when everything was as expected.
"""

import sys

import can

# The predefined master/slave connection set (CIP Vol. 3, chapter 3): 0x400 + 8 x MAC ID + message ID.
RESPONSE, REQUEST, UNCONNECTED, DUP_MAC = 3, 4, 6, 7
GAUGE, VALVE, THING = 11, 10, 20
# This client's own MAC ID.
OWN = 5


def group2(mac: int, message: int) -> int:
    return 0x400 | mac << 3 | message


class Bus:
    def __init__(self, interface: str, log: str) -> None:
        # The program sees its own frames too, so that they are in the log.
        self.bus = can.Bus(interface="socketcan", channel=interface, receive_own_messages=True)
        self.log = can.CanutilsLogWriter(log, channel=interface)

    def send(self, identifier: int, *data: int) -> None:
        self.bus.send(can.Message(arbitration_id=identifier, is_extended_id=False, data=data))
        # Its echo, or a response would be taken for a request.
        self.receive(identifier, lambda seen: seen == list(data))

    def receive(self, identifier: int, wanted=lambda data: True) -> list:
        """The data of the first frame that is wanted; others may come before it."""
        for _ in range(10_000):
            message = self.bus.recv(timeout=60.0)
            assert message is not None, f"{identifier:03X}: nothing came in 60 s"
            self.log.on_message_received(message)
            if message.arbitration_id == identifier and wanted(list(message.data)):
                return list(message.data)
        raise AssertionError(f"{identifier:03X} is not among 10000 frames")

    def request(self, mac: int, message: int, *body: int) -> list:
        """The response, put together if it comes in fragments; without its header."""
        self.send(group2(mac, message), OWN, *body)
        header, *rest = self.receive(group2(mac, RESPONSE))
        if header == OWN:
            return rest
        assert header == OWN | 0x80, f"{header:02X}"
        (fragment, *whole), count = rest, 0
        while True:
            assert fragment & 0x3F == count, f"{fragment:02X} is not fragment {count}"
            self.send(group2(mac, message), OWN | 0x80, 0xC0 | count, 0x00)
            if fragment & 0xC0 == 0x80:
                return whole
            count += 1
            header, fragment, *more = self.receive(group2(mac, RESPONSE))
            whole += more


def client(bus: Bus) -> None:
    """Allocates the explicit connection of the gauge, asks, and releases it."""
    assert bus.request(GAUGE, UNCONNECTED, 0x4B, 0x03, 0x01, 0x01, OWN) == [0xCB, 0x00]
    # Its serial number and its product name.
    assert bus.request(GAUGE, REQUEST, 0x0E, 0x01, 0x01, 0x06) == [0x8E, 0x46, 0x23, 0x00, 0x00]
    assert bus.request(GAUGE, REQUEST, 0x0E, 0x01, 0x01, 0x07) == [0x8E, 5, *b"gauge"]
    # The input assembly, which is longer than a frame.
    assert bus.request(GAUGE, REQUEST, 0x0E, 0x04, 0x64, 0x03) == [0x8E, *range(1, 13)]
    # Attribute not supported.
    assert bus.request(GAUGE, REQUEST, 0x0E, 0x01, 0x01, 0x63)[:2] == [0x94, 0x14]
    assert bus.request(GAUGE, REQUEST, 0x4C, 0x03, 0x01, 0x01) == [0xCC]


def twin(bus: Bus) -> None:
    """Wants the MAC ID of the gauge, which defends it."""
    bus.send(group2(GAUGE, DUP_MAC), 0x00, 0x99, 0x99, 0x01, 0x00, 0x00, 0x00)
    assert bus.receive(group2(GAUGE, DUP_MAC)) == [0x80, 0x34, 0x12, 0x46, 0x23, 0x00, 0x00]


def defender(bus: Bus) -> None:
    """Has the MAC ID that the valve wants."""
    print("has MAC ID 10", flush=True)
    check = bus.receive(group2(VALVE, DUP_MAC))
    assert check == [0x00, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00], check
    bus.send(group2(VALVE, DUP_MAC), 0x80, 0x99, 0x99, 0x2A, 0x00, 0x00, 0x00)


def device(bus: Bus) -> None:
    """Answers a client until that releases the connection."""
    print("is asked at MAC ID 20", flush=True)
    identity = {1: [0x99, 0x99], 2: [0x07, 0x00], 3: [0x2A, 0x00], 7: [5, *b"thing"]}
    asked = (group2(THING, UNCONNECTED), group2(THING, REQUEST))
    service = 0
    while service != 0x4C:
        message = bus.bus.recv(timeout=60.0)
        assert message is not None, "nothing came in 60 s"
        bus.log.on_message_received(message)
        if message.arbitration_id not in asked:
            continue
        header, service, *body = message.data
        if service == 0x4B:
            bus.send(group2(THING, RESPONSE), header, 0xCB, 0x00)
        elif service == 0x4C:
            bus.send(group2(THING, RESPONSE), header, 0xCC)
        else:
            assert (service, body[:2]) == (0x0E, [0x01, 0x01]), message
            bus.send(group2(THING, RESPONSE), header, 0x8E, *identity[body[2]])


def main() -> None:
    bus = Bus(sys.argv[1], sys.argv[2])
    for role in (client, twin, defender, device):
        role(bus)
    bus.log.stop()
    bus.bus.shutdown()


main()
