// The keys of the page. Every control has one, and the help lists them all.

export interface KeyEntry {
  key: string; // as KeyboardEvent.key, letters in lower case
  label: string; // what the help says
  run(): void;
  repeats?: boolean; // while it is held
}

const kSpares = "abcdefghijklmnopqrstuvwxyz0123456789";

// The text that shows a key.
export function keyName(key: string): string {
  return key === " " ? "Space" : key === "Escape" ? "Esc" : key.length === 1 ? key.toUpperCase() : key;
}

export class Keys {
  private readonly entries = new Map<string, KeyEntry>();

  add(entry: KeyEntry): void {
    if (this.entries.has(entry.key)) throw new Error(`key ${entry.key} has two meanings`);
    this.entries.set(entry.key, entry);
  }

  // Replaces the entries with this mark by others.
  remove(keys: readonly string[]): void {
    for (const key of keys) this.entries.delete(key);
  }

  // The preferred key, else the first free letter of the label, else any that is free.
  freeKey(preferred: string | undefined, label: string): string | null {
    const wishes = [preferred ?? "", ...label.toLowerCase(), ...kSpares];
    return wishes.find((key) => kSpares.includes(key) && key !== "" && !this.entries.has(key)) ?? null;
  }

  list(): KeyEntry[] {
    return [...this.entries.values()];
  }

  // Runs the entry of a pressed key. Returns true if there is one.
  press(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.altKey || event.metaKey) return false;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const entry = this.entries.get(key);
    if (!entry) return false;
    if (!event.repeat || entry.repeats) entry.run(); // a switch would flip to and fro
    return true;
  }
}
