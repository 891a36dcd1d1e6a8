// The questions after a condition: the six scales of NASA-TLX without weights, and how real the contacts
// felt. No mark is preset, and a scale cannot be left out.

import { make, makeButton } from "./dom.ts";
import type { Ratings } from "./live_protocol.ts";
import type { WordKey, Words } from "./live_words.ts";

interface Scale {
  item: keyof Ratings;
  least: number;
  most: number;
  step: number;
  low: WordKey; // what the ends mean
  high: WordKey;
}

const kTlx = { least: 0, most: 100, step: 5, low: "scale_little", high: "scale_much" } as const;
const kScales: readonly Scale[] = [
  { item: "tlx_mental", ...kTlx },
  { item: "tlx_physical", ...kTlx },
  { item: "tlx_temporal", ...kTlx },
  { item: "tlx_performance", ...kTlx, low: "scale_well", high: "scale_badly" },
  { item: "tlx_effort", ...kTlx },
  { item: "tlx_frustration", ...kTlx },
  { item: "real", least: 1, most: 7, step: 1, low: "scale_not_real", high: "scale_real" },
];

export class Questionnaire {
  readonly elements: HTMLElement[];
  private readonly ratings: Partial<Ratings> = {};
  private readonly hint = make("p", "hint");
  private readonly button: HTMLButtonElement;

  // send: receives the answers when all scales are marked.
  constructor(private readonly words: Words, send: (ratings: Ratings) => Promise<unknown>) {
    this.hint.setAttribute("role", "status");
    this.button = makeButton(words.get("go_on"), async () => {
      if (this.left === 0) await send(this.ratings as Ratings);
    }, "main");
    this.elements = [make("p", "text", words.get("questionnaire_text")),
                     ...kScales.map((scale) => this.scaleElement(scale)),
                     this.hint, make("div", "buttons", this.button)];
    this.showLeft();
  }

  private get left(): number {
    return kScales.length - Object.keys(this.ratings).length;
  }

  private scaleElement({ item, least, most, step, low, high }: Scale): HTMLElement {
    const marks = make("div", "marks");
    for (let value = least; value <= most; value += step) {
      const mark = make("input");
      mark.type = "radio";
      mark.name = item;
      mark.value = String(value);
      mark.autocomplete = "off"; // a browser keeps no mark over a reload
      mark.title = String(value);
      mark.setAttribute("aria-label", String(value));
      mark.onchange = () => {
        this.ratings[item] = value;
        this.showLeft();
      };
      marks.append(mark);
    }
    const ends = make("div", "ends", make("span", "", this.words.get(low)), make("span", "", this.words.get(high)));
    const legend = make("legend", "", make("strong", "", this.words.get(`${item}_name`)), " ",
                        this.words.get(`${item}_text`));
    return make("fieldset", `scale ${item}`, legend, marks, ends);
  }

  private showLeft(): void {
    this.button.disabled = this.left > 0;
    this.hint.textContent = this.left > 0 ? this.words.get("questionnaire_left", { count: this.left }) : "";
  }
}
