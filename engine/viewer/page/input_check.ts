// The input check of a participant: what moves, the size of the screen by a bank card, full screen, and
// whether the system accelerates a mouse.

import { fillScreen, isLocked, lockPointer, type LockKind } from "./capture.ts";
import { CardRuler, kCardWidth_mm } from "./card_ruler.ts";
import { make, makeButton, paragraphs } from "./dom.ts";
import type { Checked, Input, Motion } from "./live_protocol.ts";
import type { WordKey, Words } from "./live_words.ts";
import { kUncalibrated_px_per_mm } from "./paper_display.ts";
import { faultOf, isEven, kStrokes, motionOf, strokeRatio } from "./strokes.ts";

const kFrames = 90; // of the screen, whose times give its rate

// The rate of the screen, Hz: from the median time between frames.
async function measureRefresh(): Promise<number> {
  const times: number[] = [];
  await new Promise<void>((resolve) => {
    const frame = (now_ms: number): void => {
      times.push(now_ms);
      if (times.length > kFrames) resolve();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  });
  const gaps = times.slice(1).map((t, i) => t - (times[i] ?? t)).sort((a, b) => a - b);
  return 1000 / (gaps[gaps.length >> 1] ?? NaN);
}

// What a part of the check shows: a title, a text, and what is below.
type Show = (title: string, text: string, ...below: HTMLElement[]) => void;

export class InputCheck {
  readonly element = make("section", "check");
  private input: Input;
  private css_px_per_mm = kUncalibrated_px_per_mm;
  private lock: LockKind | null = null;
  private ratio: number | null = null;
  private readonly refresh = measureRefresh();

  // done: called with what was found.
  constructor(private readonly inputs: readonly Input[], private readonly words: Words,
              private readonly done: (checked: Checked) => Promise<void>) {
    this.input = inputs[0] ?? "mouse";
    if (inputs.length > 1) this.askInput();
    else this.askCard();
  }

  private readonly show: Show = (title, text, ...below) => {
    const heading = make("h2", "", title);
    heading.tabIndex = -1;
    this.element.replaceChildren(heading, ...paragraphs(text), ...below);
    if (this.element.isConnected) heading.focus();
  };

  private goOn(run: () => void | Promise<void>): HTMLElement {
    return make("div", "buttons", makeButton(this.words.get("go_on"), run, "main"));
  }

  private askInput(): void {
    const names: Record<Input, WordKey> = {
      mouse: "input_mouse", pen: "input_pen", touch: "input_touch", board: "input_board",
    };
    const buttons = this.inputs.map((input) => makeButton(this.words.get(names[input]), () => {
      this.input = input;
      this.askCard();
    }));
    this.show(this.words.get("input_title"), "", make("div", "buttons choices", ...buttons));
  }

  private askCard(): void {
    const ruler = new CardRuler(this.words, kCardWidth_mm * kUncalibrated_px_per_mm);
    this.show(this.words.get("card_title"), this.words.get("card_text"), ruler.element, this.goOn(() => {
      this.css_px_per_mm = ruler.css_px_per_mm;
      this.askFullScreen();
    }));
  }

  private askFullScreen(): void {
    const problem = make("p", "problem");
    problem.setAttribute("role", "alert");
    const button = makeButton(this.words.get("full_screen"), async () => {
      const fills = await fillScreen();
      problem.textContent = fills ? "" : this.words.get("full_screen_failed");
      if (!fills) return;
      if (this.input === "mouse") this.askStrokes();
      else await this.finish(this.input === "board" ? "unknown" : "unaccelerated");
    }, "main");
    this.show(this.words.get("full_screen_title"), this.words.get("full_screen_text"), problem,
              make("div", "buttons", button));
  }

  private askStrokes(): void {
    const said = make("p", "said");
    said.setAttribute("role", "status");
    const finish = (): Promise<void> => this.finish(motionOf(this.ratio, this.lock === "unadjusted"));
    const skip = makeButton(this.words.get("skip"), finish);
    const begin = makeButton(this.words.get("begin"), async () => {
      this.lock = await lockPointer();
      if (this.lock === null) {
        said.textContent = this.words.get("lock_failed");
        return;
      }
      buttons.hidden = true; // there is no pointer to press them
      const ratio = await this.measureStrokes((text) => (said.textContent = text));
      if (document.pointerLockElement) document.exitPointerLock();
      buttons.hidden = false;
      if (ratio === null) { // Esc: the person may begin again, or skip
        said.textContent = "";
        begin.focus();
        return;
      }
      this.ratio = ratio;
      said.textContent = this.words.get(isEven(ratio) ? "strokes_even" : "strokes_accelerated");
      const goOn = this.goOn(finish);
      buttons.replaceWith(goOn);
      goOn.querySelector("button")?.focus();
    }, "main");
    const buttons = make("div", "buttons", begin, skip);
    this.show(this.words.get("strokes_title"), this.words.get("strokes_text"), said, buttons);
  }

  // Waits for the strokes. say: shows what to do next. null: the person has left the lock.
  private measureStrokes(say: (text: string) => void): Promise<number | null> {
    const root = document.documentElement;
    const lengths_px: number[] = [];
    let [right, down, begin_ms] = [0, 0, NaN];
    const task = (): string => {
      const speed = kStrokes[lengths_px.length] ?? "slow";
      return this.words.get(`stroke_${speed}`, { number: lengths_px.length + 1, of: kStrokes.length });
    };
    say(task());
    return new Promise((resolve) => {
      const listening = new AbortController();
      const { signal } = listening;
      const end = (ratio: number | null): void => {
        listening.abort();
        resolve(ratio);
      };
      root.addEventListener("pointermove", (event) => {
        right += event.movementX;
        down += event.movementY;
      }, { signal });
      root.addEventListener("pointerdown", (event) => {
        [right, down, begin_ms] = [0, 0, event.timeStamp];
      }, { signal });
      root.addEventListener("pointerup", (event) => {
        const speed = kStrokes[lengths_px.length];
        if (!speed || Number.isNaN(begin_ms)) return;
        const length_px = Math.hypot(right, down);
        const fault = faultOf(speed, length_px, (event.timeStamp - begin_ms) / 1000);
        begin_ms = NaN;
        if (!fault) lengths_px.push(length_px);
        if (lengths_px.length === kStrokes.length) end(strokeRatio(lengths_px));
        else say(fault ? `${this.words.get(`stroke_${fault}`)} ${task()}` : task());
      }, { signal });
      document.addEventListener("pointerlockchange", () => {
        if (!isLocked()) end(null);
      }, { signal });
    });
  }

  private async finish(motion: Motion): Promise<void> {
    await this.done({
      input: this.input,
      motion,
      css_px_per_mm: this.css_px_per_mm,
      device_pixel_ratio: devicePixelRatio,
      width_px: screen.width,
      height_px: screen.height,
      refresh_Hz: await this.refresh,
      unadjusted: this.lock === null ? null : this.lock === "unadjusted",
      stroke_ratio: this.ratio,
    });
  }
}
