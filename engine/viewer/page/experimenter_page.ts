// The page of the experimenter of `palpate experiment live`: what the participant sees, where the course
// is, and what the experimenter may do. It cannot move the hand.

import "./experimenter.css";

import type { ConnectionState } from "./connection.ts";
import { make, makeButton } from "./dom.ts";
import {
  kEnds, type AttemptStatus, type ExperimenterAsk, type ExperimenterHello, type ExperimenterMessage,
  type ExperimenterRequest, type ExperimenterStatus, type StepName, type Trial,
} from "./live_protocol.ts";
import { kUncalibrated_px_per_mm, PaperDisplay } from "./paper_display.ts";
import type { State, Vector3 } from "./protocol.ts";
import { count, faultInWords } from "./words.ts";

const kShown_mm = 120; // of the device frame, in the smaller extent of the picture
const kNone = "\u2013"; // a number that does not exist
const kRetry_ms = 2000; // until the object is asked for again

export const experimenterConnectionWords: Record<ConnectionState, string> = {
  connecting: "Connecting\u2026", live: "",
  lost: "The connection to the program ended. Trying again\u2026",
  full: "Eight pages are open already. Trying again\u2026",
  "new address": "The program was started again. Open the new address of the experimenter that it printed.",
  refused: "The program does not accept this page. Open the address that it printed.",
  "no sockets": "A proxy blocks the connection to the program. Trying again\u2026",
  "no token": "Open the whole address of the experimenter that the program printed.",
  "wrong version": "The program has another version. Reload this page.",
};
const kSteps: Record<StepName, string> = {
  information: "Information", consent: "Consent", check: "Input check", instructions: "Instructions",
  about: "Questions about the person", learning: "Learning", practice: "Practice", block: "Block",
  questionnaire: "Questionnaire", break: "Break", paused: "Paused", debriefing: "Debriefing",
  done: "Complete", stopped: "Stopped by the participant", refused: "No consent",
};
const kStatuses: readonly AttemptStatus[] = ["done", "aborted", "skipped", "timeout", "fault"];

export interface ExperimenterHost {
  ask: ExperimenterAsk;
  fetchScene(): Promise<ArrayBuffer>;
}

// A list of names and values; a value is written only where it has changed.
class Values {
  readonly element: HTMLElement;
  private readonly values = new Map<string, HTMLElement>();

  // kind: "across" puts the values beside each other.
  constructor(title: string, names: readonly string[], kind = "") {
    const list = make("dl", `values ${kind}`);
    for (const name of names) {
      const value = make("dd", "", kNone);
      this.values.set(name, value);
      list.append(make("div", "", make("dt", "", name), value));
    }
    this.element = make("section", "group", make("h2", "", title), list);
  }

  write(name: string, text: string): void {
    const value = this.values.get(name);
    if (value && value.textContent !== text) value.textContent = text;
  }
}

export class ExperimenterPage {
  private readonly picture = make("canvas", "top-view");
  private readonly caption = make("p", "caption");
  private readonly heading = make("h1");
  private readonly course = new Values("Course", [
    "Step", "Block", "Trial", "Attempt", "Condition", "Object", "Last attempt", "Left"]);
  private readonly attempts = new Values("Attempts so far", kStatuses, "across");
  private readonly force = new Values("Force", ["Commanded", "Full", "Rules that act"], "across");
  private readonly times = new Values("Times", [
    "Newest tick late", "Worst tick late", "Missed ticks", "Pictures"], "across");
  private readonly trip = make("p", "trip");
  private readonly said = make("p", "said");
  private readonly confirm = make("dialog");
  private readonly note = make("input");
  private readonly buttons: HTMLButtonElement[] = [];
  private readonly pause: HTMLButtonElement;
  private display: PaperDisplay | null = null;
  private hello: ExperimenterHello | null = null;
  private status: ExperimenterStatus | null = null;
  private state: State | null = null;
  private trial: Trial | null = null;
  private scene = -1; // that is loaded

  constructor(private readonly host: ExperimenterHost) {
    this.trip.setAttribute("role", "alert");
    this.said.setAttribute("role", "status");
    this.picture.setAttribute("role", "img");
    this.picture.setAttribute("aria-label", "What the participant sees: the object from above.");
    this.pause = this.addButton("Pause", () => this.ask({ type: this.status?.paused ? "go_on" : "pause" }));
    this.addButton("Repeat the trial", () => this.ask({ type: "repeat" }));
    this.addButton("Rearm", () => this.ask({ type: "rearm" }));
    this.addButton("Skip the trial", () => this.askFirst("Skip this trial?",
      "It is left out of the data, and does not come again.", "skip"));
    this.addButton("Abort the trial", () => this.askFirst("Abort this trial?",
      "It ends now, and comes again at the end of its block.", "abort"));
    document.body.append(this.layOut(), this.confirm);
    new ResizeObserver(() => this.fitPicture()).observe(this.picture);
  }

  get shown(): PaperDisplay | null {
    return this.display;
  }

  greet(hello: ExperimenterHello): void {
    this.hello = hello;
    this.scene = -1; // the server may be another one
    document.documentElement.lang = "en";
    document.documentElement.dir = "ltr";
    document.title = `Experimenter: participant ${hello.participant}`;
    this.heading.textContent =
      `Participant ${hello.participant} of ${hello.plan}${hello.pilot ? " (pilot)" : ""}`;
    document.body.classList.toggle("blind", hello.blind);
    if (!hello.blind) this.openDisplay(hello);
    this.showStatus(hello.status);
    if (hello.trial) void this.showTrial(hello.trial);
  }

  receive(message: ExperimenterMessage): void {
    switch (message.type) {
      case "status": return this.showStatus(message);
      case "trial": return void this.showTrial(message);
      case "trial_end": return this.ring(null);
      case "ring": return this.ring(message.p_scene_m);
    }
  }

  receiveState(state: State): void {
    this.state = state;
    this.display?.update(state);
  }

  private addButton(name: string, press: () => unknown): HTMLButtonElement {
    const button = makeButton(name, async () => void (await press()));
    this.buttons.push(button);
    return button;
  }

  private layOut(): HTMLElement {
    this.note.maxLength = 1000; // of at most 4 bytes each, as the server permits
    this.note.autocomplete = "off";
    const send = make("button", "", "Write the note");
    const form = make("form", "note", make("label", "row", "Note, for the journal", this.note), send);
    form.onsubmit = (event) => {
      event.preventDefault();
      void this.sendNote();
    };
    return make("main", "experimenter", this.heading, this.trip,
      make("div", "buttons controls", ...this.buttons), form, this.said,
      make("div", "panels", make("figure", "view", this.picture, this.caption),
           make("div", "groups", this.course.element, this.force.element, this.times.element,
                this.attempts.element)));
  }

  // A browser without WebGL shows everything but the picture.
  private openDisplay(hello: ExperimenterHello): void {
    try {
      this.display ??= new PaperDisplay(this.picture, {
        Hz: hello.display.Hz, scale: 1, css_px_per_mm: kUncalibrated_px_per_mm,
        proxyRadius_m: hello.display.proxy_radius_m ?? 0,
      }, () => {});
    } catch {
      this.say("This browser cannot draw the picture (it has no WebGL).");
      return;
    }
    this.display.run();
  }

  private fitPicture(): void {
    const { clientWidth, clientHeight } = this.picture;
    this.display?.change({ css_px_per_mm: Math.max(1, Math.min(clientWidth, clientHeight)) / kShown_mm });
    this.display?.resize();
  }

  private async showTrial(trial: Trial): Promise<void> {
    if (!this.display) return;
    this.trial = trial;
    this.ring(null);
    while (this.scene !== trial.scene && this.trial === trial) {
      try {
        const glb = await this.host.fetchScene();
        if (this.trial !== trial) return;
        this.display.load(glb);
        this.scene = trial.scene;
      } catch {
        this.say("The object could not be loaded. Trying again\u2026");
        await new Promise((resolve) => setTimeout(resolve, kRetry_ms));
      }
    }
    if (this.trial === trial) this.display.spheres = trial;
  }

  private ring(place_scene_m: Vector3 | null): void {
    if (this.display) this.display.ringAt = place_scene_m;
  }

  private showStatus(status: ExperimenterStatus): void {
    this.status = status;
    const isOver = kEnds.includes(status.step);
    for (const button of this.buttons) button.disabled = isOver;
    this.pause.textContent = status.paused ? "Go on" : "Pause";
    this.showCourse(status);
    this.showForce(status);
    for (const kind of kStatuses) this.attempts.write(kind, count(status.attempts[kind] ?? 0));
    const { last } = status;
    this.course.write("Last attempt", last ? `${last.block === 0 ? "practice" : `block ${last.block}`}, trial ` +
      `${last.place}, attempt ${last.attempt}: ${last.status}${last.reason ? ` (${last.reason})` : ""}` : "none");
    this.times.write("Newest tick late", `${count(status.newest_late_us)} \u00b5s`);
    this.times.write("Worst tick late", `${count(status.worst_late_us)} \u00b5s`);
    this.times.write("Missed ticks", count(status.missed_deadlines));
    this.times.write("Pictures", status.pictures_Hz === null ? kNone : `${status.pictures_Hz.toFixed(1)} Hz`);
  }

  private showCourse(status: ExperimenterStatus): void {
    const hasTrial = status.place !== undefined;
    const runs = status.runs ?? status.step === "learning";
    this.course.write("Step", kSteps[status.step]);
    this.course.write("Block", status.block === 0 ? "practice" : `${status.block} of ${status.blocks}`);
    this.course.write("Trial", hasTrial ? `${status.place} of ${status.places}, ${runs ? "runs" : "is next"}` : kNone);
    this.course.write("Attempt", status.attempt === undefined ? kNone : count(status.attempt));
    const hidden = this.hello?.blind ? "hidden by the plan" : kNone;
    this.course.write("Condition", status.condition ?? hidden);
    this.course.write("Object", status.object ?? hidden);
    this.course.write("Left", `${count(status.trials_left)} trials`);
    const words = this.hello?.blind ? "The plan hides the condition, and with it the picture and the forces."
      : runs ? "What the participant sees" : "No trial runs. This is the newest picture.";
    if (this.caption.textContent !== words) this.caption.textContent = words;
  }

  private showForce(status: ExperimenterStatus): void {
    const trip = status.trip === null ? "" : `The force was cut: ${faultInWords(status.trip)}. The course is ` +
      "paused. Look after the device, press Rearm, and then Go on.";
    if (this.trip.textContent !== trip) this.trip.textContent = trip;
    const { record } = this.state ?? {};
    const newtons = (force?: Vector3): string => (force ? `${Math.hypot(...force).toFixed(2)} N` : kNone);
    this.force.write("Commanded", newtons(record?.force_device_N));
    this.force.write("Full", newtons(record?.full_force_device_N));
    this.force.write("Rules that act", (status.rules ?? []).map(faultInWords).join(", ") || "none");
  }

  // "": nothing.
  private say(text: string): void {
    this.said.textContent = text;
  }

  private async ask(request: ExperimenterRequest): Promise<boolean> {
    this.say("");
    const answer = await this.host.ask(request);
    this.say(answer.ok ? "" : `Not done: ${answer.problem ?? "no reason was given"}`);
    return answer.ok;
  }

  private async sendNote(): Promise<void> {
    const text = this.note.value.trim();
    if (text === "" || !(await this.ask({ type: "note", text }))) return;
    this.note.value = "";
    this.say("The note is in the journal.");
  }

  // What is asked for is meant for the trial of this moment.
  private askFirst(title: string, text: string, type: "skip" | "abort"): void {
    const { block = 0, place = 0, attempt = 0 } = this.status ?? {};
    const heading = make("h2", "", title);
    heading.id = "confirm-title";
    this.confirm.setAttribute("aria-labelledby", heading.id);
    const back = makeButton("Back", () => this.confirm.close());
    const yes = makeButton(title.replace("?", ""), async () => {
      this.confirm.close();
      await this.ask({ type, block, place, attempt });
    }, "main");
    this.confirm.replaceChildren(heading, make("p", "text", text), make("div", "buttons", back, yes));
    this.confirm.showModal();
    back.focus();
  }
}
