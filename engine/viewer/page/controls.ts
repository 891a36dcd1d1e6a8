// The settings that the server offers: one control each, with a key, an accessible name and an answer.

import { make } from "./dom.ts";
import { keyName, type Keys } from "./keys.ts";
import type { Answer, Setting, SettingValue } from "./protocol.ts";

const kSliderSteps = 1000;
const kWideRange = 50; // a range this much wider than the value gets a slider with cubic steps
const kPower = 3;
const kDigits = 3;
const kMaterialKey = "m"; // goes to the next field
const kMaterialFields = "input[type=number], .segments button:first-child";

export type SetRequest = (name: string, value: SettingValue) => Promise<Answer>;

interface Control {
  readonly element: HTMLElement;
  show(value: SettingValue): void;
  activate(): void; // by its key
}

function keyHint(key: string | null): HTMLElement {
  const hint = make("kbd", "", key ? keyName(key) : "");
  hint.setAttribute("aria-hidden", "true");
  hint.hidden = key === null;
  return hint;
}

// A value of a slider's position in [0, 1] and back.
export function sliderScale(low: number, high: number, value: number): {
  valueAt(share: number): number; shareOf(value: number): number;
} {
  const power = high - low > kWideRange * Math.max(value - low, 0) && value > low ? kPower : 1;
  return {
    valueAt: (share) => {
      const exact = low + (high - low) * share ** power;
      return Math.min(high, Math.max(low, Number(exact.toPrecision(kDigits))));
    },
    shareOf: (v) => ((Math.min(high, Math.max(low, v)) - low) / (high - low)) ** (1 / power),
  };
}

function flagControl(setting: Setting, key: string | null, set: (v: SettingValue) => void): Control {
  const button = make("button", "toggle", setting.label);
  button.type = "button";
  button.setAttribute("role", "switch");
  button.append(keyHint(key));
  let isOn = false;
  const flip = (): void => set(!isOn);
  button.onclick = flip;
  return {
    element: button,
    show: (value) => {
      isOn = value === true;
      button.setAttribute("aria-checked", String(isOn));
    },
    activate: flip,
  };
}

function choiceControl(setting: Setting, key: string | null,
                       set: (v: SettingValue) => void): Control {
  const box = make("div", "row");
  box.setAttribute("role", "group");
  box.setAttribute("aria-label", setting.label);
  const group = make("div", "segments");
  const choices = setting.choices ?? [];
  let now: SettingValue = setting.value;
  const buttons = choices.map((choice) => {
    const button = make("button", "", choice);
    button.type = "button";
    button.onclick = () => set(choice);
    group.append(button);
    return button;
  });
  const label = make("span", "label", setting.label);
  label.append(keyHint(key));
  box.append(label, group);
  return {
    element: box,
    show: (value) => {
      now = value;
      buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(choices[i] === value)));
    },
    activate: () => set(choices[(choices.indexOf(String(now)) + 1) % choices.length] ?? now),
  };
}

// Buttons A1, A2 and A3. The value is the list of the axes with a motor.
function axesControl(setting: Setting, key: string | null, sensors: number,
                     set: (v: SettingValue) => void): Control {
  const box = make("div", "row");
  box.setAttribute("role", "group");
  box.setAttribute("aria-label", setting.label);
  const group = make("div", "segments");
  let on = new Set<number>();
  const axis = (n: number): number[] => [0, 1, 2].map((i) => (i === n ? 1 : 0));
  const send = (wanted: Set<number>): void => set([...wanted].sort().map(axis));
  const flip = (n: number): void => {
    const wanted = new Set(on);
    if (!wanted.delete(n)) wanted.add(n);
    send(wanted);
  };
  const buttons = Array.from({ length: sensors }, (_, n) => {
    const button = make("button", "", `A${n + 1}`);
    button.type = "button";
    button.setAttribute("aria-label", `motor on A${n + 1}`);
    button.onclick = () => flip(n);
    group.append(button);
    return button;
  });
  const label = make("span", "label", setting.label);
  label.append(keyHint(key));
  box.append(label, group);
  return {
    element: box,
    show: (value) => {
      const list = Array.isArray(value) ? value : [];
      const axisOf = (v: number[]): number => v.findIndex((x) => Math.abs(x) > 1 - 1e-9);
      on = new Set(list.map(axisOf).filter((n) => n >= 0));
      box.dataset["oblique"] = String(list.some((v) => axisOf(v) < 0)); // no button shows such an axis
      buttons.forEach((button, n) => button.setAttribute("aria-pressed", String(on.has(n))));
    },
    activate: () => { // the next of the 2^sensors sets of axes
      const bits = [...on].reduce((sum, n) => sum + (1 << n), 0);
      const next = (bits + 1) % (1 << sensors);
      send(new Set(Array.from({ length: sensors }, (_, n) => n).filter((n) => (next >> n) & 1)));
    },
  };
}

function numberControl(setting: Setting, key: string | null,
                       set: (v: SettingValue) => void): Control {
  const low = setting.low ?? 0;
  const high = setting.high ?? 1;
  const scale = sliderScale(low, high, Number(setting.value));
  const box = make("div", "row number");
  const label = make("label", "label", setting.label);
  label.append(keyHint(key));
  const slider = make("input");
  slider.type = "range";
  slider.max = String(kSliderSteps);
  slider.setAttribute("aria-label", `${setting.label}, slider`);
  const field = make("input");
  field.type = "number";
  field.min = String(low);
  field.max = String(high);
  field.step = "any";
  field.id = `setting-${setting.name.replaceAll(/[^A-Za-z0-9]/g, "-")}`;
  label.htmlFor = field.id;
  const unit = make("span", "unit", setting.unit === "1" ? "" : setting.unit ?? "");
  const entry = make("span", "entry");
  entry.append(field, unit);
  box.append(label, entry, slider);
  slider.oninput = () => {
    const value = scale.valueAt(Number(slider.value) / kSliderSteps);
    field.value = String(value);
    set(value);
  };
  field.onchange = () => {
    if (field.value.trim() !== "") set(Number(field.value)); // else the next status shows the old one
  };
  return {
    element: box,
    show: (value) => {
      const number = Number(value);
      if (document.activeElement !== field) field.value = String(Number(number.toPrecision(6)));
      slider.value = String(Math.round(kSliderSteps * scale.shareOf(number)));
    },
    activate: () => field.select(),
  };
}

export class SettingControls {
  private readonly controls = new Map<string, Control>();
  private readonly values = new Map<string, SettingValue>();
  private readonly pending = new Map<string, number>(); // requests without an answer
  private keysInUse: string[] = [];

  constructor(
    private readonly main: HTMLElement, private readonly materials: HTMLElement,
    private readonly keys: Keys, private readonly request: SetRequest,
    private readonly refuse: (problem: string) => void,
  ) {}

  // Replaces all controls.
  build(settings: readonly Setting[], sensors: number): void {
    this.keys.remove(this.keysInUse);
    this.keysInUse = [];
    this.controls.clear();
    this.pending.clear();
    this.main.replaceChildren();
    this.materials.replaceChildren();
    const hasMaterials = settings.some(({ name }) => name.startsWith("material/"));
    const details = this.materials.closest("details");
    if (details) details.hidden = !hasMaterials;
    if (hasMaterials) { // before a setting takes this key
      this.keysInUse.push(kMaterialKey);
      this.keys.add({ key: kMaterialKey, label: "Next value of a material",
                      run: () => this.focusNextMaterial() });
    }
    for (const setting of settings) this.add(setting, sensors);
  }

  // Shows the values of the engine, except those for which a request is under way.
  show(values: Record<string, SettingValue>): void {
    for (const [name, value] of Object.entries(values)) {
      if ((this.pending.get(name) ?? 0) === 0) this.showOne(name, value);
    }
  }

  enable(isEnabled: boolean): void {
    for (const control of this.controls.values()) {
      const parts = control.element.querySelectorAll<HTMLButtonElement | HTMLInputElement>("button, input");
      for (const part of parts) part.disabled = !isEnabled;
      if (control.element instanceof HTMLButtonElement) control.element.disabled = !isEnabled;
    }
  }

  valueOf(name: string): SettingValue | undefined {
    return this.values.get(name);
  }

  // Materials can be many: one key goes from field to field, instead of a key for each.
  private focusNextMaterial(): void {
    const details = this.materials.closest("details");
    if (details) details.open = true;
    const fields = [...this.materials.querySelectorAll<HTMLElement>(kMaterialFields)];
    const field = fields[(fields.indexOf(document.activeElement as HTMLElement) + 1) % fields.length];
    field?.focus();
    if (field instanceof HTMLInputElement) field.select();
  }

  private add(setting: Setting, sensors: number): void {
    const isOfMaterial = setting.name.startsWith("material/");
    const key = isOfMaterial ? null : this.keys.freeKey(setting.key, setting.label);
    const set = (value: SettingValue): void => void this.send(setting.name, value);
    const control = setting.kind === "flag" ? flagControl(setting, key, set)
      : setting.kind === "choice" ? choiceControl(setting, key, set)
      : setting.kind === "axes" ? axesControl(setting, key, sensors, set)
      : numberControl(setting, key, set);
    control.element.dataset["setting"] = setting.name;
    this.controls.set(setting.name, control);
    if (key) {
      this.keysInUse.push(key);
      this.keys.add({ key, label: setting.label, run: () => control.activate() });
    }
    (isOfMaterial ? this.materials : this.main).append(control.element);
    this.showOne(setting.name, setting.value);
  }

  private showOne(name: string, value: SettingValue): void {
    this.controls.get(name)?.show(value);
    this.values.set(name, value);
  }

  private async send(name: string, value: SettingValue): Promise<void> {
    this.pending.set(name, (this.pending.get(name) ?? 0) + 1);
    const answer = await this.request(name, value);
    const pending = (this.pending.get(name) ?? 1) - 1;
    this.pending.set(name, pending);
    if (answer.ok) {
      if (pending === 0) this.showOne(name, value); // else the user has moved on
    } else {
      this.refuse(answer.problem ?? "the server refused the setting");
      const known = this.values.get(name);
      if (known !== undefined) this.controls.get(name)?.show(known);
    }
  }
}
