"""A simulated board and the hand that holds it, in a process of its own (simulated_board.cpp)."""

import json
import subprocess

# The origin of the device frame, the middle of the workspace, in the frame of the linkage.
MIDDLE_M = (0.01, 0.0546)


class Board:
    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port = json.loads(self.process.stdout.readline())["port"]

    def tell(self, **order):
        """The board's report, once it has obeyed."""
        self.process.stdin.write(json.dumps(order) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def read(self):
        return self.tell(read=True)

    def pull(self, x, y):
        """The hand pulls the tip to this place of the device frame."""
        return self.tell(hand_m=[x + MIDDLE_M[0], y + MIDDLE_M[1]])

    def end(self):
        self.process.communicate()
