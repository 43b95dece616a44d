"""Frames of HTTP/2 by hand, for clients that break the rules (RFC 9113)."""
import select
import socket
import struct
import time

DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = 0, 1, 3, 4, 6, 7, 8, 9
END_STREAM, END_HEADERS, ACK = 1, 4, 1
PATIENCE_S = 10


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + bytes((kind, flags)) + struct.pack(">I", stream) + payload


def literal(name, value):
    """A header that no table holds (RFC 7541, section 6.2.2); both parts are shorter than 127 bytes."""
    name, value = name.encode(), value.encode()
    return b"\0" + bytes((len(name),)) + name + bytes((len(value),)) + value


def headers_of(path, *more):
    return b"".join(literal(*h) for h in ((":method", "POST"), (":scheme", "http"), (":path", path), (":authority", "a"),
                                          ("content-type", "application/grpc"), ("te", "trailers"), *more))


class Connection:
    """One connection.  `window`: what each stream of the server may send before the client asks for more."""

    def __init__(self, port, window=2**31 - 1):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.next, self.closed, self.received = 1, False, b""
        self.replies = b""  # to the server's settings and pings; not allowed inside of a header
        self.stream_window, self.windows = 65535, {0: 65535}
        self.send(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(SETTINGS, 0, 0, struct.pack(">HI", 4, window)) +
                  frame(SETTINGS, ACK, 0))

    def stream(self):
        self.next += 2
        self.windows[self.next - 2] = self.stream_window
        return self.next - 2

    def send(self, data):
        """Sends all, and reads what comes.  Returns whether the connection is still open."""
        view = memoryview(data)
        while view and not self.closed:
            readable, writable, _ = select.select([self.socket], [self.socket], [], PATIENCE_S)
            if readable:
                self.read()
            if writable and not self.closed:
                try:
                    view = view[self.socket.send(view[:1 << 20]):]
                except OSError:
                    self.closed = True
            if not readable and not writable:
                break
        return not self.closed

    def read(self):
        """Reads frames, and keeps what the server's windows say."""
        try:
            more = self.socket.recv(1 << 20)
        except OSError:
            more = b""
        self.closed |= not more
        self.received += more
        while len(self.received) >= 9 and len(self.received) >= 9 + int.from_bytes(self.received[:3], "big"):
            size = int.from_bytes(self.received[:3], "big")
            kind, flags, stream = struct.unpack(">BBI", self.received[3:9])
            payload, self.received = self.received[9:9 + size], self.received[9 + size:]
            if kind == WINDOW_UPDATE:
                self.windows[stream] = self.windows.get(stream, self.stream_window) + struct.unpack(">I", payload)[0]
            if kind == PING and not flags & ACK:
                self.replies += frame(PING, ACK, 0, payload)
            if kind == SETTINGS and not flags & ACK:
                self.replies += frame(SETTINGS, ACK, 0)
                for i in range(0, size, 6):
                    name, value = struct.unpack(">HI", payload[i:i + 6])
                    if name == 4:
                        for s in self.windows:
                            self.windows[s] += (value - self.stream_window) if s else 0
                        self.stream_window = value
            if kind == GOAWAY:
                self.goaway = payload

    def send_data(self, streams, size):
        """Sends up to `size` bytes on each stream, as far as the server's windows allow.  Returns all bytes sent."""
        left, sent, end = dict.fromkeys(streams, size), 0, time.monotonic() + PATIENCE_S
        while any(left.values()) and not self.closed and time.monotonic() < end:
            moved = False
            for s in streams:
                n = min(left[s], 16384, self.windows[s], self.windows[0])
                if n <= 0:
                    continue
                self.send(frame(DATA, 0, s, bytes(n)))
                left[s] -= n
                self.windows[s] -= n
                self.windows[0] -= n
                sent, moved = sent + n, True
            if not moved and select.select([self.socket], [], [], 1)[0]:
                self.read()
                replies, self.replies = self.replies, b""
                self.send(replies)
        return sent
