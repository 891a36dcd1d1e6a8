// A picture of a bank card that a person makes as large as a real one, so that lengths on the screen are
// known.

import { make } from "./dom.ts";
import type { Words } from "./live_words.ts";

// Format ID-1 of ISO/IEC 7810.
export const kCardWidth_mm = 85.6;
const kCardHeight_mm = 53.98;
const kLeast_px = 160;
const kMost_px = 1600;
const kLargeStep_px = 10;

export class CardRuler {
  readonly element: HTMLElement;
  private readonly card: HTMLElement;
  private width: number;

  // width_px: at first.
  constructor(private readonly words: Words, width_px: number) {
    this.card = make("div", "card", make("span", "chip"), make("span", "corner"));
    this.card.tabIndex = 0;
    this.card.setAttribute("role", "slider");
    this.card.setAttribute("aria-label", words.get("card_label"));
    this.card.setAttribute("aria-valuemin", String(kLeast_px));
    this.card.setAttribute("aria-valuemax", String(kMost_px));
    this.element = make("div", "ruler", this.card);
    this.width = width_px;
    this.set(width_px);
    this.card.addEventListener("keydown", (event) => this.key(event));
    this.card.addEventListener("pointerdown", (event) => this.drag(event));
  }

  get css_px_per_mm(): number {
    return this.width / kCardWidth_mm;
  }

  private set(width_px: number): void {
    this.width = Math.min(kMost_px, Math.max(kLeast_px, width_px));
    this.card.style.width = `${this.width}px`;
    this.card.style.height = `${(this.width * kCardHeight_mm) / kCardWidth_mm}px`;
    this.card.setAttribute("aria-valuenow", String(Math.round(this.width)));
    this.card.setAttribute("aria-valuetext", this.words.get("card_value", { pixels: Math.round(this.width) }));
  }

  private key(event: KeyboardEvent): void {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (sign === undefined) return;
    event.preventDefault();
    this.set(this.width + sign * (event.shiftKey ? kLargeStep_px : 1));
  }

  // The corner opposite to the beginning of the line follows the pointer.
  private drag(event: PointerEvent): void {
    this.card.setPointerCapture(event.pointerId);
    this.card.focus();
    const begin_px = this.width;
    const sign = getComputedStyle(this.card).direction === "rtl" ? -1 : 1;
    const move = (now: PointerEvent): void => this.set(begin_px + sign * (now.clientX - event.clientX));
    const end = (): void => {
      this.card.removeEventListener("pointermove", move);
      this.card.removeEventListener("pointerup", end);
      this.card.removeEventListener("pointercancel", end);
    };
    this.card.addEventListener("pointermove", move);
    this.card.addEventListener("pointerup", end);
    this.card.addEventListener("pointercancel", end);
  }
}
