#!/usr/bin/env python3
"""Recomputes the measures of trials.csv from the traces of the trials alone.

usage: trial_measures_test.py PROGRAM MODELS

Runs small plans with --traces. Clock and measures are computed here from their definitions: the
columns of the ticks, the centres of the spheres in the glTF file, and A1 as the only motor. Whole
numbers must be equal. Sums may differ by rounding: a sum of n terms by n + 16 roundings of the sum of
the terms' magnitudes, of which 16 are for the arithmetic within a term.
"""

import csv
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

ROUNDING = 2.0 ** -53

FAULTS = ["non_finite_sample", "bad_time_step", "solver_capped", "jump", "body_held",
          "bad_body_pose", "non_finite_force", "far_sample", "bad_settings", "invalid_sample",
          "bad_actuation", "effects_capped"]

PAPER = {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
         "damping_Ns_per_m": 2}
COMMON = {"palpate_plan": 1, "participants": 1, "blocks": 1, "practice_blocks": 0,
          "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"]}
PLANS = [
    # The device of the paper's plan, whole trials.
    {**COMMON, "name": "whole", "seed": 11, "device": PAPER, "display_Hz": 40,
     "sphere_radius_m": 0.006, "limit_s": 120, "objects": {"O1": "star.glb"},
     "operator": "people2005", "followings": ["delayed"]},
    # A spherical proxy and a rate whose time step is not exact; trials end at the time limit. The
    # radius of the spheres is no multiple of the encoder's step of 20 um, so that rounding does not
    # decide which contacts lie within them.
    {**COMMON, "name": "cut off", "seed": 12,
     "device": {**PAPER, "rate_Hz": 700, "stiffness_N_per_m": 600, "radius_m": 0.002},
     "display_Hz": 30, "sphere_radius_m": 0.00801, "limit_s": 12, "objects": {"O4": "lock.glb"},
     "operator": "literature", "followings": ["predict"]},
    # Strategies, with a limit of the force that the governor enforces.
    {"palpate_plan": 1, "participants": 1, "blocks": 1, "practice_blocks": 0,
     "strategies": ["mask", "a4", "a4-anticipate", "a4-passive:2",
                                          "anisotropic:4", "cd"], "name": "strategies",
     "seed": 13, "device": {**PAPER, "max_force_N": 5}, "display_Hz": 40, "sphere_radius_m": 0.006,
     "limit_s": 20, "objects": {"O1": "star.glb"}, "operator": "people2005",
     "followings": ["delayed"]},
]


def spheres(model):
    """The centres of the green and the red sphere that a glTF file states."""
    data = model.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    contour = json.loads(data[20:20 + length])["nodes"][0]["extras"]["palpate_contour"]
    return contour["start_m"], contour["end_m"]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def norm(a):
    return math.sqrt(dot(a, a))


def rotated(q, v):
    """The vector v, rotated by the unit quaternion w, x, y, z: v + 2 u x (u x v + w v)."""
    w, u = q[0], q[1:]
    t = [a + w * b for a, b in zip(cross(u, v), v)]
    return [a + 2 * b for a, b in zip(v, cross(u, t))]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class Ticks:
    """The ticks of a trace."""

    def __init__(self, path):
        with open(path, newline="") as file:
            rows = csv.reader(file)
            names = next(rows)
            self.rows = list(rows)
        self.place = {name: i for i, name in enumerate(names)}

    def vectors(self, name, axes="xyz"):
        places = [self.place[f"{name}_{axis}"] for axis in axes]
        return [[float(row[i]) for i in places] for row in self.rows]

    def texts(self, name):
        return [row[self.place[name]] for row in self.rows]

    def numbers(self, name):
        return [float(row[self.place[name]]) for row in self.rows]


class Sum:
    """An exact sum, and the bound of the error of a sum that rounds."""

    def __init__(self):
        self.terms = []
        self.magnitude = 0.0

    def add(self, term, magnitude=None):
        self.terms.append(term)
        self.magnitude += abs(term) if magnitude is None else magnitude

    def value(self, divisor=1.0):
        bound = (len(self.terms) + 16) * ROUNDING * self.magnitude
        return math.fsum(self.terms) / divisor, bound / divisor


def clocked(contact, touched, green, red, radius):
    """First and last tick of the clock, and the status of the trial."""
    def touches(i, centre):
        return contact[i] and norm(minus(touched[i], centre)) <= radius

    ticks = len(contact)
    first = next(i for i in range(ticks) if touches(i, green))
    # Near its start a person may touch the red sphere, too: both are on one wall.
    stops = [i for i in range((first + ticks) // 2, ticks) if touches(i, red)]
    if not stops:
        return first, ticks - 1, "timeout"
    return first, stops[0], "done" if stops[0] == ticks - 1 else "done, at an earlier tick"


def turns(contact, turning, wait):
    """How many turns in free motion end without a touch within `wait` ticks."""
    empty, since = 0, None
    for touches, turns_now in zip(contact, turning):
        if touches:
            since = None
        elif turns_now:
            since = 0
        elif since is not None:
            since += 1
            if since == wait:
                empty, since = empty + 1, None
    return empty


def turning_energy(ticks, first, last):
    """What turns add to the energy of the motors' part of the spring while the proxy is on one wall.
    Before a turn, the motors' part of the stretch is that of the lag times the commanded part of the
    projected force; after it, the start of the spring is that of the next tick."""
    force, full = ticks.vectors("force"), ticks.vectors("full_force")
    normal, pose = ticks.vectors("normal"), ticks.vectors("q", "wxyz")
    lag = [rotated(q, minus(p, g)) for q, p, g in
           zip(pose, ticks.vectors("proxy"), ticks.vectors("goal"))]
    walls, turned = ticks.numbers("contacts"), ticks.numbers("rotation_deg")
    governed = [names not in ("", "order") for names in ticks.texts("rules")]
    energy = Sum()
    for i in range(first + 1, last + 1):
        if walls[i - 1] != 1 or walls[i] != 1 or normal[i - 1] != normal[i] or turned[i - 1] == 0:
            continue
        if governed[i - 1] or governed[i] or force[i][0] == 0 or full[i][0] == 0:
            continue
        length, n = norm(lag[i]), rotated(pose[i], normal[i])
        start = (1 - force[i][0] / full[i][0]) * length
        after = max(0.0, dot(lag[i - 1], n) - start) * abs(n[0])
        part = force[i - 1][0] / full[i - 1][0] if force[i - 1][0] else 0.0
        before = norm(lag[i - 1]) * part * abs(rotated(pose[i - 1], normal[i - 1])[0])
        stiffness = norm(full[i]) / length
        energy.add(max(0.0, stiffness / 2 * (after ** 2 - before ** 2)),
                   stiffness * (length ** 2 + norm(lag[i - 1]) ** 2))
    return energy.value()


def travel(positions):
    """The largest extent of the positions along an axis; a difference rounds once."""
    extents = [max(of_axis) - min(of_axis) for of_axis in zip(*positions)]
    return max(extents), ROUNDING * max(extents)


def strategy_measures(ticks, plan, first, last):
    """Exact measures, and expected value and bound of the others, of a plan with strategies. Drift
    has no value if the scene has turned."""
    device, force = ticks.vectors("device"), ticks.vectors("force")
    normal, pose, origin = ticks.vectors("normal"), ticks.vectors("q", "wxyz"), ticks.vectors("o")
    contact = [c == 1.0 for c in ticks.numbers("contact")]
    wall, works, of_contact, drift, worst = Sum(), [], Sum(), Sum(), 0.0
    for i in range(first, last + 1):
        away = norm(minus(origin[i], origin[0]))
        drift.add(away)
        worst = max(worst, away)
        if i == first or not contact[i - 1]:
            continue
        moved = minus(device[i], device[i - 1])
        n = rotated(pose[i - 1], normal[i - 1])
        along = dot(force[i - 1], n)
        magnitude = norm(force[i - 1]) * norm(moved)
        wall.add(max(0.0, dot(minus(force[i - 1], [along * x for x in n]), moved)), magnitude)
        of_contact.add(dot(force[i - 1], moved), magnitude)
        if not contact[i] or i == last:
            works.append(of_contact.value())
            of_contact = Sum()
    governed = sum(names != "" for names in ticks.texts("rules")[first:])
    exact = {"empty_turns": turns(contact[first:], [r != 0 for r in ticks.numbers("rotation_deg")[first:]],
                                  round(0.1 * plan["device"]["rate_Hz"]))}
    count = last - first + 1
    near = {"wall_work_J": wall.value(), "largest_contact_work_J": max(works),
            "governor_share": (governed / count, ROUNDING),
            "turning_energy_J": turning_energy(ticks, first, last),
            "device_travel_m": travel(device[first:last + 1])}
    if all(q == pose[0] for q in pose[first:]):
        near["mean_drift_m"] = drift.value(count)
        near["worst_drift_m"] = (worst, 16 * ROUNDING * worst)
    return exact, near


def measures(ticks, plan, model):
    """Expected value and bound of each measure; the status of the trial."""
    dt = 1.0 / plan["device"]["rate_Hz"]
    proxy, goal = ticks.vectors("proxy"), ticks.vectors("goal")
    normal, device = ticks.vectors("normal"), ticks.vectors("device")
    force, full = ticks.vectors("force"), ticks.vectors("full_force")
    pose, time = ticks.vectors("q", "wxyz"), ticks.numbers("t")
    contact = [c == 1.0 for c in ticks.numbers("contact")]
    radius = plan["device"].get("radius_m", 0.0)
    touched = [minus(p, [radius * x for x in n]) for p, n in zip(proxy, normal)]
    green, red = spheres(model)
    first, last, status = clocked(contact, touched, green, red, plan["sphere_radius_m"])

    depth, angle, ghost, missing = Sum(), Sum(), Sum(), Sum()
    device_path, proxy_path, port, lost = Sum(), Sum(), Sum(), Sum()
    contact_ticks = losses = long_losses = gap = within = nearly_within = held = 0
    for i in range(first, last + 1):
        if i > first:
            moved = minus(device[i], device[i - 1])
            device_path.add(norm(moved))
            proxy_path.add(norm(minus(proxy[i], proxy[i - 1])))
            # The force of a tick is held until the next one.
            port.add(dot(force[i - 1], moved), norm(force[i - 1]) * norm(moved))
            lost.add(dot(minus(full[i - 1], force[i - 1]), moved),
                     (norm(full[i - 1]) + norm(force[i - 1])) * norm(moved))
            held += contact[i - 1]
            losses += contact[i - 1] and not contact[i]
        gap = 0 if contact[i] else gap + 1
        long_losses += gap == round(0.1 / dt)
        if not contact[i]:
            continue
        contact_ticks += 1
        depth.add(norm(minus(proxy[i], goal[i])))
        n = rotated(pose[i], normal[i])
        degrees = math.degrees(math.atan2(math.hypot(n[1], n[2]), abs(n[0])))
        angle.add(degrees, 90.0)
        within += degrees <= 30.0 - 1e-10
        nearly_within += degrees <= 30.0 + 1e-10
        along = dot(force[i], n)
        ghost.add(norm(minus(force[i], [along * x for x in n])), norm(force[i]))
        missing.add(norm(full[i]) - along, norm(full[i]) + norm(force[i]))

    total = time[last] - time[first]
    exact = {"losses_of_contact": losses, "losses_100ms": long_losses, "missed_deadlines": 0}
    for fault in FAULTS:
        exact[fault] = sum(fault in names.split("+") for names in ticks.texts("faults")[first:])
    near = {
        "total_time_s": (total, len(time) * ROUNDING * time[last]),
        "contact_s": (held * dt, 2 * ROUNDING * held * dt),
        "losses_per_s": (losses / total, losses / total * len(time) * ROUNDING * 4),
        "losses_100ms_per_s": (long_losses / total, long_losses / total * len(time) * ROUNDING * 4),
        "mean_penetration_m": depth.value(contact_ticks),
        "mean_penetration_dm": depth.value(contact_ticks / 10),
        "mean_contact_angle_deg": angle.value(contact_ticks),
        "share_within_30deg": ((within + nearly_within) / 2 / contact_ticks,
                               (nearly_within - within + ROUNDING) / contact_ticks),
        "device_path_m": device_path.value(),
        "proxy_path_m": proxy_path.value(),
        "port_work_J": port.value(),
        "work_lost_J": lost.value(),
        "mean_ghost_force_N": ghost.value(contact_ticks),
        "mean_missing_force_N": missing.value(contact_ticks),
    }
    if "strategies" in plan:
        more_exact, more_near = strategy_measures(ticks, plan, first, last)
        exact.update(more_exact)
        near.update(more_near)
    if status == "timeout" and len(time) != round(plan["limit_s"] / dt):
        status = "timeout at the limit"
    return exact, near, status


def trace_of(folder, row):
    place = [f"trial-{row['trial']}-", f"trial-0{row['trial']}-"]
    traces = folder / "traces" / row["following"] / f"participant-{row['participant']}"
    found = [t for t in traces.glob(f"block-{row['block']}-*") if any(p in t.name for p in place)]
    assert len(found) == 1, (traces, row["trial"])
    return found[0]


def judge(program, models, plan, folder):
    """Returns the number of trials and a line for each difference."""
    plan = dict(plan, objects={k: str(models / v) for k, v in plan["objects"].items()})
    path = folder / "plan.json"
    path.write_text(json.dumps(plan))
    subprocess.run([program, "experiment", "run", path, "--out", folder, "--traces"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(folder / "trials.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    wrong = []
    for row in rows:
        ticks = Ticks(trace_of(folder, row))
        exact, near, status = measures(ticks, plan, pathlib.Path(plan["objects"][row["object"]]))
        levels = row.get("strategy") or f"{row['haptic']} {row['rotation']}"
        name = f"{plan['name']}, trial {row['trial']} ({levels})"
        if "strategies" in plan and ("mean_drift_m" in near) == (row["mean_drift_m"] == ""):
            wrong.append(f"{name}: mean_drift_m is \"{row['mean_drift_m']}\"")
        if row["status"] != status:
            wrong.append(f"{name}: status is {row['status']}; expected {status}")
        for column, value in exact.items():
            if row[column] != str(value):
                wrong.append(f"{name}: {column} is {row[column]}; expected {value}")
        for column, (value, bound) in near.items():
            if not abs(float(row[column]) - value) <= bound:
                wrong.append(f"{name}: {column} is {row[column]}; expected {value:.17g} "
                             f"+- {bound:.2g}")
    return len(rows), wrong


def main():
    program, models = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    wrong, trials = [], 0
    for plan in PLANS:
        with tempfile.TemporaryDirectory() as folder:
            count, lines = judge(program, models, plan, pathlib.Path(folder))
            trials += count
            wrong += lines
    for line in wrong:
        print(line)
    print(f"{trials} trials, {len(wrong)} differences")
    return 1 if wrong or trials == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
