// The buttons of the page itself, each with a key, and the help that lists all keys.

import { keyName, type Keys } from "./keys.ts";

export interface Actions {
  start(): void;
  pause(): void;
  rearm(): void;
  stay(): void;
  takeControl(): void;
  letGo(): void;
  camera(): void;
  fit(): void;
  zoom(factor: number): void;
  triangles(isShown: boolean): void;
  loadAll(): void;
  screenshot(): void;
  theme(): void;
}

const kZoomStep = 1.25;
const kFixedKeys = [ // of the view itself, which pointing.ts handles
  ["Arrows", "move the hand"],
  ["PgUp PgDn", "depth of the hand (3 sensors)"],
  ["\u21e7 Arrows", "turn the view (3 sensors)"],
] as const;

function box(id: string): HTMLElement {
  return document.getElementById(id) as HTMLElement;
}

export class PageButtons {
  private readonly controlled: HTMLButtonElement[] = []; // only for the page in control
  private readonly pauseButton: HTMLButtonElement;
  private readonly rearmButton: HTMLButtonElement;
  private readonly takeButton: HTMLButtonElement;
  private readonly cameraButton: HTMLButtonElement;
  private readonly allButton: HTMLButtonElement;
  private isInControl = false;
  private isTripped = false;

  constructor(private readonly keys: Keys, actions: Actions) {
    const hand = box("hand-buttons");
    const view = box("view-buttons");
    this.takeButton = this.add(hand, "Take control", "x", actions.takeControl);
    this.pauseButton = this.add(hand, "Pause", " ", actions.pause, true);
    this.add(hand, "Start position", "s", actions.start, true);
    this.add(hand, "Let go", "Escape", actions.letGo, true);
    this.rearmButton = this.add(hand, "Rearm", "r", actions.rearm, true);
    this.add(box("inside-buttons"), "Stay inside", "i", actions.stay, true);
    this.cameraButton = this.add(view, "Follow the ball", "c", actions.camera);
    this.add(view, "Fit", "f", actions.fit);
    let isShown = false;
    const triangles: HTMLButtonElement = this.add(view, "Felt triangles", "t", () => {
      isShown = !isShown;
      triangles.setAttribute("aria-pressed", String(isShown));
      actions.triangles(isShown);
    });
    triangles.setAttribute("aria-pressed", "false");
    this.cameraButton.setAttribute("aria-pressed", "false");
    this.pauseButton.setAttribute("aria-pressed", "false");
    this.allButton = this.add(view, "Load all triangles", "g", actions.loadAll);
    this.allButton.hidden = true;
    this.add(view, "Nearer", "+", () => actions.zoom(kZoomStep));
    this.add(view, "Farther", "-", () => actions.zoom(1 / kZoomStep));
    this.add(view, "Picture", "p", actions.screenshot);
    this.add(view, "Dark or light", "d", actions.theme);
    this.add(view, "Keys", "?", () => this.showHelp());
    box("help-close").onclick = () => (box("help") as HTMLDialogElement).close();
  }

  enable(isInControl: boolean): void {
    this.isInControl = isInControl;
    for (const button of this.controlled) button.disabled = !isInControl;
    this.rearmButton.disabled = !isInControl || !this.isTripped;
  }

  showTripped(isTripped: boolean): void {
    if (isTripped === this.isTripped) return;
    this.isTripped = isTripped;
    this.enable(this.isInControl);
  }

  showWatching(isWatching: boolean): void {
    this.takeButton.hidden = !isWatching;
  }

  showPaused(isPaused: boolean): void {
    this.pauseButton.setAttribute("aria-pressed", String(isPaused));
  }

  // Offers all triangles if the scene was simplified.
  showSimplified(isSimplified: boolean): void {
    this.allButton.hidden = !isSimplified;
  }

  showCamera(isCamera: boolean): void {
    this.cameraButton.setAttribute("aria-pressed", String(isCamera));
  }

  // Leaves the buttons of the hand, over the drawing; the keys of the others do nothing.
  showOnlyHand(): void {
    box("view-buttons").hidden = true;
    box("stage").append(box("hand-buttons"));
  }

  private add(parent: HTMLElement, label: string, key: string, run: () => void,
              isControlled = false): HTMLButtonElement {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = label;
    const hint = document.createElement("kbd");
    hint.textContent = keyName(key);
    hint.setAttribute("aria-hidden", "true");
    button.append(hint);
    button.onclick = run;
    button.setAttribute("aria-keyshortcuts", key === " " ? "Space" : key);
    this.keys.add({ key, label, repeats: key === "+" || key === "-", run: () => {
      if (!button.disabled && !button.closest("[hidden]")) run();
    } });
    if (isControlled) this.controlled.push(button);
    parent.append(button);
    return button;
  }

  private showHelp(): void {
    const list = box("help-keys");
    const rows = [...kFixedKeys, ...this.keys.list().map(({ key, label }) => [keyName(key), label] as const)];
    list.replaceChildren(...rows.map(([key, label]) => {
      const row = document.createElement("div");
      const name = document.createElement("dt");
      const hint = document.createElement("kbd");
      hint.textContent = key;
      name.append(hint);
      const text = document.createElement("dd");
      text.textContent = label;
      row.append(name, text);
      return row;
    }));
    (box("help") as HTMLDialogElement).showModal();
  }
}
