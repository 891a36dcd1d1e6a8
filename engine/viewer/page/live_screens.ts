// What the participant's page shows outside trials: one screen for each step of the course.

import { make, makeButton, paragraphs } from "./dom.ts";
import { InputCheck } from "./input_check.ts";
import type { AboutKey, Ask, Checked, Input, LiveRequest, Step, StepName } from "./live_protocol.ts";
import { timeLeft, type WordKey, type Words } from "./live_words.ts";
import { Questionnaire } from "./questionnaire.ts";

// Steps after which a trial begins.
const kBeforeTrials: readonly StepName[] = ["learning", "practice", "block", "paused"];
const kHands = ["left", "right", "both"] as const;

export interface ScreenHost {
  words: Words;
  inputs: readonly Input[];
  clutchHint(): string; // how the hand may be set back; "": there is nothing to say
  ask: Ask;
  say(problem: string): void;
  capture(): Promise<boolean>; // fills the screen and locks the pointer for trials
  checked(checked: Checked): void; // the server has accepted it
}

export class Screen {
  private countdown: HTMLElement | null = null;
  private end_ms = 0; // of the break, of performance.now()
  private timer = 0;

  constructor(private readonly element: HTMLElement, private readonly step: Step,
              private readonly host: ScreenHost) {
    const heading = make("h1", "", step.title ?? this.word(`title_${step.step}`));
    heading.tabIndex = -1;
    const parts: HTMLElement[] = [...this.progress(), heading, ...paragraphs(step.text), ...this.body()];
    element.replaceChildren(...parts);
    heading.focus();
    scrollTo(0, 0);
  }

  // The rest of a break as the server knows it.
  setRemaining(remaining_s: number): void {
    this.end_ms = performance.now() + 1000 * remaining_s;
    this.showRemaining();
  }

  close(): void {
    clearInterval(this.timer);
    this.element.replaceChildren();
  }

  private word(key: WordKey, values: Record<string, string | number> = {}): string {
    return this.host.words.get(key, values);
  }

  private progress(): HTMLElement[] {
    const { step, number, of } = this.step;
    if (step === "practice") return [make("p", "progress", this.word("practice"))];
    return step === "block" ? [make("p", "progress", this.word("block_of", { number, of }))] : [];
  }

  private body(): HTMLElement[] {
    switch (this.step.step) {
      case "consent": return this.consent();
      case "check": return [this.check()];
      case "about": return this.about();
      case "questionnaire": return this.questionnaire();
      case "break": return this.pauseForRest();
      case "instructions": return [...paragraphs(this.host.clutchHint()), ...this.next()];
      case "paused": return [this.buttons(this.goOnButton({ type: "go_on" }))];
      case "done":
      case "stopped":
      case "refused": return [];
      default: return this.next();
    }
  }

  private buttons(...buttons: HTMLElement[]): HTMLElement {
    return make("div", "buttons", ...buttons);
  }

  // Asks the server, and says why it refuses.
  private async ask(request: LiveRequest): Promise<boolean> {
    const answer = await this.host.ask(request);
    this.host.say(answer.ok ? "" : this.word("refused", { problem: answer.problem ?? "" }));
    return answer.ok;
  }

  private goOnButton(request: LiveRequest): HTMLButtonElement {
    return makeButton(this.word("go_on"), async () => {
      // Without the lock the trial asks for another click.
      if (kBeforeTrials.includes(this.step.step)) await this.host.capture();
      await this.ask(request);
    }, "main");
  }

  private next(): HTMLElement[] {
    const { step, may_go_on } = this.step;
    return may_go_on ? [this.buttons(this.goOnButton({ type: "next", step }))] : [];
  }

  private consent(): HTMLElement[] {
    const box = make("input");
    box.type = "checkbox";
    const agree = makeButton(this.word("agree"), async () => {
      if (box.checked) await this.ask({ type: "consent", value: true });
    }, "main");
    const hint = make("p", "hint", this.word("consent_needs_box"));
    agree.disabled = true;
    box.onchange = () => {
      agree.disabled = !box.checked;
      hint.hidden = box.checked;
    };
    const refuse = makeButton(this.word("disagree"), async () => {
      await this.ask({ type: "consent", value: false });
    });
    return [make("label", "tick", box, make("span", "", this.word("consent_box"))), hint,
            this.buttons(agree, refuse)];
  }

  private check(): HTMLElement {
    const { inputs, words } = this.host;
    return new InputCheck(inputs, words, async (checked) => {
      if (await this.ask({ type: "checked", ...checked })) this.host.checked(checked);
    }).element;
  }

  private about(): HTMLElement[] {
    const fields = this.step.about.map((key) => ({ key, field: this.aboutField(key) }));
    const rows = fields.map(({ key, field }) => make("label", "row", this.word(`about_${key}`), field));
    const send = makeButton(this.word("go_on"), async () => {
      const given = fields.map(({ key, field }) => [key, field.value.trim()] as const);
      await this.ask({ type: "about", answers: Object.fromEntries(given.filter(([, value]) => value !== "")) });
    }, "main");
    return [make("p", "hint", this.word("about_note")), ...rows, this.buttons(send)];
  }

  private aboutField(key: AboutKey): HTMLInputElement | HTMLSelectElement {
    if (key === "hand") {
      const choices = kHands.map((hand) => new Option(this.word(`about_${hand}`), hand));
      const list = make("select");
      list.append(new Option(this.word("about_open"), ""), ...choices);
      return list;
    }
    const field = make("input");
    field.autocomplete = "off"; // nothing of another participant is offered
    field.maxLength = 200;
    if (key === "age") field.inputMode = "numeric";
    return field;
  }

  private questionnaire(): HTMLElement[] {
    return new Questionnaire(this.host.words, async (answers) => {
      await this.host.capture(); // the next trial comes by itself
      await this.ask({ type: "rated", answers });
    }).elements;
  }

  private pauseForRest(): HTMLElement[] {
    const { remaining_s } = this.step;
    if (remaining_s === null) return this.next();
    this.countdown = make("p", "countdown");
    this.countdown.setAttribute("role", "timer");
    this.setRemaining(remaining_s);
    this.timer = window.setInterval(() => this.showRemaining(), 250);
    return [this.countdown, ...this.next()];
  }

  private showRemaining(): void {
    if (!this.countdown) return;
    const left_s = (this.end_ms - performance.now()) / 1000;
    this.countdown.textContent = left_s > 0 ? this.word("break_left", { time: timeLeft(left_s) })
                                            : this.word("break_over");
  }
}
