// Numbers and faults in words.

const kFaultWords: Record<string, string> = {
  non_finite_sample: "position is not a number",
  bad_time_step: "time step is not valid",
  solver_capped: "solver reached its limit",
  jump: "position jumped",
  body_held: "moving body was stopped by the ball",
  bad_body_pose: "pose of a body was ignored",
  non_finite_force: "force is not a number",
  far_sample: "position is too far away",
  bad_settings: "settings are not valid",
  invalid_sample: "device marked its sample as invalid",
  bad_actuation: "new motor axes were ignored",
  effects_capped: "magnets and media reached their limit",
  bad_sample: "a bad sample stopped a motor",
  motors: "motors cannot push part of the force",
  peak: "a motor reached its peak force",
  clamp: "force was limited",
  slew: "growth of the force was limited",
  speed: "device moved too fast",
  stale: "newest sample is too old",
  order: "an old sample was ignored",
  late: "tick came too late",
  workspace: "device is outside its workspace",
  ease: "force returns after an interruption",
  start: "force waits for a calm hand",
  tripped: "governor has tripped",
};

// A fault or a rule of the governor, by its name in the engine.
export function faultInWords(name: string): string {
  return kFaultWords[name] ?? name.replaceAll("_", " ");
}

// A count with a thin space between thousands.
export function count(value: number): string {
  return Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, "\u2009");
}

// Faults since the last status, the most frequent first; "" if there are none.
export function faultsInWords(faults: Record<string, number>): string {
  return Object.entries(faults)
    .sort((a, b) => b[1] - a[1])
    .map(([name, n]) => `${faultInWords(name)} (${count(n)})`)
    .join(", ");
}

// What is touched: "box, wood"; "" if nothing is.
export function touchedInWords(bodyName: string, materialName: string): string {
  return [bodyName, materialName].filter((name) => name !== "").join(", ");
}

// A length in the unit that suits it.
export function length(metres: number): string {
  if (metres >= 1) return `${Number(metres.toPrecision(3))} m`;
  return `${Number((1000 * metres).toPrecision(3))} mm`;
}
