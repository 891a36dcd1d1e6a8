// Makes elements of a page. Texts are always shown as text.

type Child = Node | string;

// An element with a class ("": none) and children.
export function make<K extends keyof HTMLElementTagNameMap>(tag: K, kind = "", ...children: Child[]):
    HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (kind !== "") element.className = kind;
  element.append(...children);
  return element;
}

// A button. While `run` has not ended, another press does nothing.
export function makeButton(text: string, run: () => void | Promise<void>, kind = ""): HTMLButtonElement {
  const button = make("button", kind, text);
  button.type = "button";
  let isRunning = false;
  button.onclick = async () => {
    if (isRunning) return;
    isRunning = true;
    try {
      await run();
    } finally {
      isRunning = false;
    }
  };
  return button;
}

// The paragraphs of a plain text; blank lines separate them.
export function paragraphs(text: string): HTMLParagraphElement[] {
  return text.split(/\n\s*\n/).filter((part) => part.trim() !== "")
    .map((part) => make("p", "text", part.trim()));
}
