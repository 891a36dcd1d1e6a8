"""What the page says about a user's own scene."""

from __future__ import annotations

from typing import Any

from palpate.analysis.accuracy.texts import FLOOR
from palpate.analysis.numbers import human, short_number


def _error(error_m: float, floor_m: float) -> str:
    return human(error_m, "m") if error_m > floor_m else FLOOR + human(floor_m, "m")


def _spread(spread: dict[str, float]) -> tuple[str, str]:
    return (human(spread["median"], "ns"),
            f"[{human(spread['low'], 'ns')}, {human(spread['high'], 'ns')}]")


def _preset(preset: dict[str, Any], floor_m: float) -> dict[str, Any]:
    return {"name": preset["name"],
            "times": [_spread(preset[of]) for of in ("p50_ns", "p99_ns", "worst_ns")],
            "numbers": [*(_error(preset[of], floor_m) for of in
                          ("rms_error_m", "p99_error_m", "worst_error_m")),
                        human(preset["worst_force_error_N"], "N"),
                        short_number(preset["iterations"]), preset["capped_ticks"]]}


def content(facts: dict[str, Any]) -> dict[str, Any]:
    """The texts of the section, from the member `scene` of accuracy.json."""
    rate = facts["kept_rate"]
    trials = [{"rate": human(trial["rate_Hz"], "Hz"), "passed": trial["passed"],
               "numbers": [f"{trial['kept']} of {trial['trials']}", trial["ticks"], trial["missed"],
                           human(trial["longest_ns"], "ns")]} for trial in rate["trials"]]
    surfaces = [surface | {"numbers": [
        surface["effective"], surface["passive_up_to"], surface["limited_by"],
        surface["stable_below"], human(surface["stiffness_N_per_m"], "N/m"),
        human(surface["damping_Ns_per_m"], "N s/m")]} for surface in facts["surfaces"]]
    limits = [[human(at["rate_Hz"], "Hz"), human(at["passive_N_per_m"], "N/m"),
               human(at["stable_N_per_m"], "N/m")] for at in facts["limits"]]
    return facts | {
        "contact": short_number(100.0 * facts["contact_share"]) + " %",
        "seconds": short_number(facts["seconds"]),
        "floor": human(facts["floor_m"], "m"),
        "presets": [_preset(preset, facts["floor_m"]) for preset in facts["presets"]],
        "kept": human(rate["rate_Hz"], "Hz") if rate["rate_Hz"] > 0.0
        else "none of the rates tried",
        "kept_by_trial": human(rate["by_trial_Hz"], "Hz") if rate["by_trial_Hz"] > 0.0
        else "no rate",
        "kept_by_computing": human(rate["by_computing_Hz"], "Hz"),
        "realtime_note": rate["realtime_note"],
        "trials": trials,
        "motors_delay": human(facts["motors_delay_s"], "s"),
        "deepest": human(facts["deepest_m"], "m"),
        "rate": human(facts["rate_Hz"], "Hz"),
        "surfaces": surfaces,
        "limits": limits,
    }
