// A trial of a participant: the paper's display, the motions of the pointer, and what ends a trial.

import { capture, fillsScreen, isLocked, onScreenChange } from "./capture.ts";
import { make, makeButton } from "./dom.ts";
import type { Ask, Checked, LeftWhy, LiveHello, LiveNotice, Trial } from "./live_protocol.ts";
import type { WordKey, Words } from "./live_words.ts";
import { kUncalibrated_px_per_mm, PaperDisplay } from "./paper_display.ts";
import { kRepeat_ms } from "./pointer.ts";
import { PointerSum } from "./pointer_sum.ts";
import type { State, Vector3 } from "./protocol.ts";

const kFrames_ms = 200; // between messages with the times of pictures
const kMostTimes = 100; // in such a message
const kRetry_ms = 2000; // until the object is asked for again

// waiting: for the person, before a trial. running: between the answer to `ready` and trial_end. between:
// after trial_end. left: it was running until the person left.
export type TrialPhase = "none" | "loading" | "waiting" | "starting" | "running" | "between" | "left";

export interface TrialHost {
  ask: Ask;
  tell(notice: LiveNotice): void;
  point(target_m: Vector3, isHeld: boolean, isClutched: boolean): void;
  fetchScene(): Promise<ArrayBuffer>;
  pause(): void;
  stop(): void;
  say(problem: string): void; // "": nothing
}

export class TrialView {
  private readonly canvas = make("canvas", "picture");
  private readonly overlay = make("div", "overlay");
  private readonly bar = make("div", "bar");
  private readonly display: PaperDisplay;
  private readonly sum: PointerSum;
  private hello: LiveHello | null = null;
  private checked: Checked | null = null;
  private trial: Trial | null = null;
  private scene = -1; // that is loaded
  private times_ms: number[] = [];
  private timers: number[] = [];
  private learned = -1; // the number of the condition that the person has ended
  phase: TrialPhase = "none";

  // onDrawn: called with the time of each picture. Throws an Error if the browser has no WebGL.
  constructor(private readonly element: HTMLElement, private readonly words: Words,
              private readonly host: TrialHost, onDrawn: (time_ms: number) => void) {
    element.append(this.canvas, this.bar, this.overlay);
    this.overlay.setAttribute("role", "dialog");
    this.canvas.setAttribute("role", "img");
    const settings = { Hz: 40, scale: 1, css_px_per_mm: kUncalibrated_px_per_mm, proxyRadius_m: 0 };
    this.display = new PaperDisplay(this.canvas, settings, (time_ms) => {
      if (this.phase === "running") this.times_ms.push(time_ms);
      onDrawn(time_ms);
    });
    this.sum = new PointerSum(this.canvas, () => this.sendTarget());
    new ResizeObserver(() => this.rescale()).observe(this.canvas);
    addEventListener("blur", () => this.leave("focus"));
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.leave("hidden");
    });
    document.addEventListener("pointerlockchange", () => {
      if (this.needsLock && !isLocked()) this.leave("pointer_lock");
    });
    onScreenChange(() => {
      if (!fillsScreen()) this.leave("full_screen");
    });
    addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || event.repeat || !this.isLearning) return;
      event.preventDefault();
      void this.endLearning();
    });
    for (const type of ["keydown", "keyup"] as const) {
      addEventListener(type, (event) => this.takeClutchKey(event));
    }
    element.addEventListener("contextmenu", (event) => event.preventDefault()); // of a long press
  }

  get shown(): PaperDisplay {
    return this.display;
  }

  get green(): Vector3 | null {
    return this.trial?.green_m ?? null;
  }

  // checked: null if the input check was not made in this page, nor before a reload.
  greet(hello: LiveHello, checked: Checked | null): void {
    this.hello = hello;
    this.scene = -1; // the server may be another one
    this.canvas.setAttribute("aria-label", this.words.get("trial_picture"));
    this.overlay.setAttribute("aria-label", this.words.get("left_title"));
    this.display.change({
      Hz: hello.display.Hz, scale: hello.display.scale, proxyRadius_m: hello.display.proxy_radius_m ?? 0,
    });
    this.sum.permitsClutch = hello.clutch ?? false;
    this.setChecked(checked);
  }

  // How the hand may be set back; "": there is nothing to say.
  clutchHint(place: "instructions" | "bar"): string {
    const isInBar = place === "bar";
    if (this.sum.input === "board") return "";
    if (this.sum.input !== "mouse") {
      if (this.sum.permitsClutch) return this.words.get(isInBar ? "bar_lift_clutch" : "clutch_lift");
      return this.words.get(isInBar ? "bar_lift" : "lift_ends");
    }
    if (!this.sum.permitsClutch) return "";
    return this.words.get(isInBar ? "bar_clutch" : "clutch_mouse");
  }

  setChecked(checked: Checked | null): void {
    this.checked = checked;
    this.sum.input = checked?.input ?? this.hello?.inputs[0] ?? "mouse";
    this.rescale();
    this.makeBar();
  }

  // Prepares the trial, and starts it when the person is ready for it.
  async start(trial: Trial): Promise<void> {
    if (this.trial?.number === trial.number && (this.phase === "running" || this.phase === "starting")) return; // told twice
    const mustClick = !this.overlay.hidden && this.phase !== "none"; // the person had left, and has not come back
    this.finish();
    this.trial = trial;
    this.phase = "loading";
    this.element.hidden = false;
    this.display.resize();
    this.display.spheres = trial;
    this.display.ringAt = null;
    this.display.run();
    this.showProgress(trial);
    if (this.scene !== trial.scene && !(await this.load(trial))) return;
    if (this.trial !== trial) return;
    if (this.whyNotReady() === null && !mustClick) await this.begin(trial);
    else this.wait("waiting");
  }

  // The person does something else than the trial, such as to ask for the end.
  interrupt(): void {
    this.leave("focus");
  }

  end(number: number): void {
    if (this.trial?.number !== number || this.phase !== "running") return;
    this.finish();
    this.trial = null;
    this.phase = "between";
    this.ring(null);
  }

  ring(place_scene_m: Vector3 | null): void {
    this.display.ringAt = place_scene_m;
    const hint = this.bar.querySelector<HTMLElement>(".ring");
    if (hint) hint.textContent = place_scene_m ? this.words.get("ring_hint") : "";
  }

  receive(state: State): void {
    this.display.update(state);
  }

  // Ends what is shown and frees the pointer; the screen stays filled.
  hide(): void {
    this.finish();
    this.trial = null;
    this.phase = "none";
    this.display.stop();
    this.element.hidden = true;
    this.overlay.hidden = true;
    if (isLocked()) document.exitPointerLock();
  }

  // Fills the screen and locks the pointer as trials need it. Call it in a click.
  capture(): Promise<boolean> {
    return capture(this.needsLock);
  }

  private get needsLock(): boolean {
    return this.sum.input === "mouse";
  }

  // What the person does instead of a trial; null: they can begin one.
  private whyNotReady(): LeftWhy | null {
    if (document.hidden) return "hidden";
    if (!document.hasFocus() || document.querySelector("dialog[open]")) return "focus";
    if (this.needsLock && !isLocked()) return "pointer_lock";
    return fillsScreen() ? null : "full_screen";
  }

  // A page that was zoomed since the check has larger CSS pixels.
  private rescale(): void {
    const { css_px_per_mm = kUncalibrated_px_per_mm, device_pixel_ratio = devicePixelRatio } = this.checked ?? {};
    this.display.change({ css_px_per_mm: (css_px_per_mm * device_pixel_ratio) / devicePixelRatio });
    this.display.resize();
  }

  // Returns false if another trial has come meanwhile.
  private async load(trial: Trial): Promise<boolean> {
    while (this.trial === trial) {
      try {
        const glb = await this.host.fetchScene();
        if (this.trial !== trial) return false;
        this.display.load(glb);
        this.scene = trial.scene;
        this.host.say("");
        return true;
      } catch {
        this.host.say(this.words.get("scene_missing"));
        await new Promise((resolve) => setTimeout(resolve, kRetry_ms));
      }
    }
    return false;
  }

  private async begin(trial: Trial): Promise<void> {
    this.phase = "starting";
    this.overlay.hidden = true;
    this.sum.reset();
    const answer = await this.host.ask({ type: "ready", trial: trial.number });
    if (this.trial !== trial || this.phase !== "starting") return;
    if (!answer.ok) {
      this.host.say(this.words.get("refused", { problem: answer.problem ?? "" }));
      this.wait("waiting");
      return;
    }
    this.phase = "running";
    this.timers = [
      window.setInterval(() => this.sendTarget(), kRepeat_ms),
      window.setInterval(() => this.sendTimes(), kFrames_ms),
    ];
    this.sendTarget();
    const why = this.whyNotReady();
    if (why) this.leave(why); // since the server was asked
  }

  // Ends the messages of the running trial.
  private finish(): void {
    for (const timer of this.timers) clearInterval(timer);
    this.timers = [];
    this.sendTimes();
  }

  private leave(why: LeftWhy): void {
    switch (this.phase) {
      case "running":
        this.finish();
        this.host.tell({ type: "left", why });
        return this.wait("left");
      case "left":
      case "waiting":
      case "between":
        return this.wait(this.phase);
      default: // loading and starting look for themselves
    }
  }

  // Shows what the person can do while the pointer is free.
  private wait(phase: "waiting" | "between" | "left"): void {
    this.phase = phase;
    const text = (key: WordKey): HTMLElement => make("p", "text", this.words.get(key));
    const goOn = makeButton(this.words.get("go_on"), () => this.goOn(), "main");
    this.overlay.replaceChildren(
      ...(phase === "left" ? [make("h2", "", this.words.get("left_title")), text("left_text")]
                           : [text("click_to_go_on")]),
      make("div", "buttons", goOn, makeButton(this.words.get("pause"), () => this.host.pause()),
           makeButton(this.words.get("stop"), () => this.host.stop())));
    this.overlay.hidden = false;
    if (isLocked()) document.exitPointerLock();
    goOn.focus();
  }

  private async goOn(): Promise<void> {
    if (!(await this.capture())) {
      this.host.say(this.words.get("lock_failed"));
      return;
    }
    this.host.say("");
    this.overlay.hidden = true;
    if (this.phase === "waiting" && this.trial) await this.begin(this.trial);
    // Otherwise the next trial comes by itself.
  }

  // The person touches a condition as long as they like.
  private get isLearning(): boolean {
    return this.phase === "running" && this.trial?.step === "learning";
  }

  // The space bar, where a mouse may be set back; it presses no button meanwhile.
  private takeClutchKey(event: KeyboardEvent): void {
    if (event.key !== " " || this.phase !== "running" || !this.needsLock || !this.sum.permitsClutch) return;
    event.preventDefault();
    this.sum.setKey(event.type === "keydown");
  }

  private async endLearning(): Promise<void> {
    if (!this.trial || this.learned === this.trial.number) return; // the key was pressed twice
    this.learned = this.trial.number;
    const answer = await this.host.ask({ type: "next", step: "learning" });
    if (answer.ok) return;
    this.learned = -1; // the person may ask again
    this.host.say(this.words.get("refused", { problem: answer.problem ?? "" }));
  }

  private sendTarget(): void {
    if (this.phase !== "running" || !this.trial || this.sum.input === "board") return;
    const [x, y, z] = this.trial.start_device_m;
    const metres = 1 / this.display.pixels_per_m;
    // Seen from above with A1 up, A2 points to the left.
    this.host.point([x + metres * this.sum.up_px, y - metres * this.sum.right_px, z], this.sum.holds,
                    this.sum.isClutched);
  }

  private sendTimes(): void {
    while (this.times_ms.length > 0) {
      this.host.tell({ type: "frames", times_ms: this.times_ms.splice(0, kMostTimes) });
    }
  }

  // The keys of a locked pointer; buttons for those who can press them.
  private makeBar(): void {
    const ring = make("span", "ring");
    ring.setAttribute("role", "status");
    const progress = make("span", "progress");
    if (this.needsLock) {
      this.bar.replaceChildren(progress, make("span", "keys", this.words.get("trial_keys")),
                               make("span", "clutch", this.clutchHint("bar")), ring);
      return;
    }
    const pause = makeButton(this.words.get("pause"), () => this.host.pause());
    const stop = makeButton(this.words.get("stop"), () => this.host.stop());
    const goOn = makeButton(this.words.get("go_on"), () => this.endLearning());
    goOn.classList.add("learned");
    goOn.hidden = true;
    this.bar.replaceChildren(progress, make("span", "clutch", this.clutchHint("bar")), ring, goOn, pause, stop);
  }

  private showProgress({ number, place, of, step }: Trial): void {
    const progress = this.bar.querySelector(".progress");
    const isLearning = step === "learning";
    if (progress) {
      progress.textContent = isLearning ? this.words.get("learning_hint")
                                        : this.words.get("trial_of", { number: place ?? number, of });
    }
    const goOn = this.bar.querySelector<HTMLElement>("button.learned");
    if (goOn) goOn.hidden = !isLearning;
    this.ring(null);
  }
}
