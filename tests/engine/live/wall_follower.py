"""A hand that follows a contour with what it feels: no map of the scene, no model of the engine."""

import math
import struct




class Record:
    """Some members of TickRecord (palpate/record.h)."""

    def __init__(self, data):
        self.tick, self.time_s = struct.unpack_from("<Qd", data, 0)
        self.device = struct.unpack_from("<3d", data, 16)
        self.proxy = struct.unpack_from("<3d", data, 64)
        self.normal = struct.unpack_from("<3d", data, 88)
        self.q = struct.unpack_from("<4d", data, 160)
        self.o = struct.unpack_from("<3d", data, 192)
        self.contact, = struct.unpack_from("<H", data, 316)

    def to_device(self, x, y):
        """A point of the scene in its plane, in the device frame: a turn about A3, and a shift."""
        w, _, _, z = self.q
        turn = 2.0 * math.atan2(z, w)
        return (math.cos(turn) * x - math.sin(turn) * y + self.o[0],
                math.sin(turn) * x + math.cos(turn) * y + self.o[1], self.device[2])


class WallFollower:
    """Touches the wall at the green sphere, then goes along it with the material on its left."""

    speed_m = 1.5e-3  # from one state to the next
    depth_m = 1.0e-3  # into the wall
    turn = math.radians(20)  # from one state to the next, once contact is lost

    def __init__(self, green_m):
        self.green = green_m
        self.inward = None  # the direction into the wall that was touched last
        self.lost = 0  # states since the last contact
        self.at = None  # the target, scene frame

    def target(self, record):
        """The next target of the device point, device frame."""
        if record.contact and any(record.normal):
            n = math.hypot(record.normal[0], record.normal[1])
            self.inward = (-record.normal[0] / n, -record.normal[1] / n)
            self.lost = 0
            ahead = (self.inward[1], -self.inward[0])  # its left is inward
            self.at = (record.proxy[0] + self.speed_m * ahead[0] + self.depth_m * self.inward[0],
                       record.proxy[1] + self.speed_m * ahead[1] + self.depth_m * self.inward[1])
        elif self.inward is None:
            x, y = self.at or record.proxy[:2]
            dx, dy = self.green[0] - x, self.green[1] - y
            away = max(math.hypot(dx, dy), 1e-9)
            step = min(self.speed_m, away) if away > 1e-6 else self.speed_m
            self.at = (x + step * dx / away, y + step * dy / away)
        else:
            self.lost += 1
            angle = min(self.lost * self.turn, math.pi)
            ahead = (self.inward[1], -self.inward[0])
            along, into = math.cos(angle), math.sin(angle)
            self.at = (self.at[0] + self.speed_m * (along * ahead[0] + into * self.inward[0]),
                       self.at[1] + self.speed_m * (along * ahead[1] + into * self.inward[1]))
        return record.to_device(*self.at)
