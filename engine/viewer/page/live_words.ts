// The words of the participant's page: those of the server, which a plan may translate, or the English
// ones of live_words.json.

import english from "./live_words.json";

export type WordKey = keyof typeof english;

export class Words {
  private texts: Record<string, string> = english;

  // Keys that the page does not know are ignored.
  set(words: Record<string, string>): void {
    this.texts = { ...english, ...words };
  }

  // The text of a key, in which {name} stands for a value.
  get(key: WordKey, values: Record<string, string | number> = {}): string {
    const text = this.texts[key] ?? english[key];
    return text.replace(/\{([a-z]+)\}/g, (whole, name: string) =>
      name in values ? String(values[name]) : whole);
  }
}

// A time that is left, as minutes and seconds.
export function timeLeft(seconds: number): string {
  const whole = Math.max(0, Math.ceil(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
