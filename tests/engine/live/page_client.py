"""A page of `palpate experiment live` without a browser: a WebSocket client (RFC 6455) that speaks
the messages of engine/viewer/messages.h and engine/live/live_request.h.

Needs the standard library only. One thread uses an object.
"""

import base64
import json
import os
import socket
import struct
import urllib.parse

TEXT, BINARY, CLOSE, PING = 1, 2, 8, 9


class Closed(Exception):
    """The server has closed the connection."""


class PageClient:
    def __init__(self, address, timeout_s=10.0):
        """address: as the program prints it, with the token behind #."""
        parts = urllib.parse.urlsplit(address)
        self.token = parts.fragment
        self.host = parts.netloc
        self.socket = socket.create_connection((parts.hostname, parts.port), timeout_s)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer = b""
        self.texts = []  # JSON messages that nobody has asked for yet
        self.states = []  # binary states
        self.next_id = 0
        self.sequence = 0
        self._shake_hands()
        self.send({"type": "token", "token": self.token})
        self.hello = self.expect("hello")

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _shake_hands(self):
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET /live HTTP/1.1\r\nHost: {self.host}\r\nOrigin: http://{self.host}\r\n"
                             "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Key: {key}\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.buffer:
            self._receive()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Closed(head.decode(errors="replace"))

    def _receive(self):
        data = self.socket.recv(65536)
        if not data:
            raise Closed("the connection has ended")
        self.buffer += data

    def _send_frame(self, kind, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([0x80 | kind])
        if size < 126:
            head += bytes([0x80 | size])
        else:
            head += bytes([0x80 | 126]) + struct.pack(">H", size)
        repeated = (mask * (size // 4 + 1))[:size]
        masked = (int.from_bytes(payload, "big") ^ int.from_bytes(repeated, "big")).to_bytes(size, "big")
        self.socket.sendall(head + mask + masked)

    def send(self, message):
        self._send_frame(TEXT, json.dumps(message).encode())

    def point(self, target_m, buttons=1):
        """Puts the device point there (device frame). buttons: 1: holds, 2: the clutch is pressed."""
        self.sequence += 1
        self._send_frame(BINARY, struct.pack("<HHIQ3d", 16, self.hello["version"], buttons, self.sequence,
                                             *target_m))

    def read_frame(self):
        """Reads one frame, and keeps what it holds in texts or states."""
        while True:
            if len(self.buffer) >= 2:
                size, start = self.buffer[1] & 0x7F, 2
                if size == 126 and len(self.buffer) >= 4:
                    size, start = struct.unpack_from(">H", self.buffer, 2)[0], 4
                elif size == 127 and len(self.buffer) >= 10:
                    size, start = struct.unpack_from(">Q", self.buffer, 2)[0], 10
                elif size >= 126:
                    size = 1 << 62
                if len(self.buffer) >= start + size:
                    break
            self._receive()
        kind, payload = self.buffer[0] & 0x0F, self.buffer[start:start + size]
        self.buffer = self.buffer[start + size:]
        if kind == TEXT:
            self.texts.append(json.loads(payload))
        elif kind == BINARY:
            self.states.append(payload)
        elif kind == PING:
            self._send_frame(10, payload)
        elif kind == CLOSE:
            raise Closed(payload[2:].decode(errors="replace"))

    def expect(self, kind, **values):
        """The next JSON message of this type with these values; messages before it are dropped."""
        while True:
            while self.texts:
                message = self.texts.pop(0)
                if message["type"] == kind and all(message.get(k) == v for k, v in values.items()):
                    return message
            self.read_frame()

    def ask(self, kind, **body):
        """Sends a request. The answer: None, or the problem."""
        self.next_id += 1
        self.send({"type": kind, "id": self.next_id, **body})
        kept = []
        while True:
            while self.texts:
                message = self.texts.pop(0)
                if message["type"] == "answer" and message["id"] == self.next_id:
                    self.texts = kept + self.texts
                    return None if message["ok"] else message["problem"]
                kept.append(message)
            self.read_frame()

    def newest_state(self):
        """Waits for a state. Returns the sequence of the pointer that it used, and its record."""
        self.states.clear()
        while not self.states:
            self.read_frame()
        state = self.states[-1]
        sequence, = struct.unpack_from("<Q", state, 8)
        size, = struct.unpack_from("<I", state, 48)
        return sequence, state[136:136 + size]
