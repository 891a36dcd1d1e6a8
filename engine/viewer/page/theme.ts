// The colours of the page, which theme.css defines, for the drawing and the charts.

export interface Palette {
  background: string;
  felt: string;
  edge: string;
  grid: string;
  shadow: number; // opacity
  ball: string;
  ballFree: string;
  plate: string;
  device: string;
  line: string;
  normal: string;
  force: string;
  rail: string;
  target: string;
  text: string;
  quiet: string;
  rule: string;
  full: string;
  limit: string;
}

export type Theme = "dark" | "light";
const kThemeKey = "palpate-theme";

export function systemTheme(): Theme {
  return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
}

export function chosenTheme(): Theme {
  const stored = sessionStorage.getItem(kThemeKey);
  return stored === "dark" || stored === "light" ? stored : systemTheme();
}

export function applyTheme(theme: Theme): void {
  document.documentElement.dataset["theme"] = theme;
}

export function chooseTheme(theme: Theme): void {
  sessionStorage.setItem(kThemeKey, theme);
  applyTheme(theme);
}

export function palette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const color = (name: string): string => style.getPropertyValue(`--${name}`).trim();
  return {
    background: color("view"),
    felt: color("felt"),
    edge: color("edge"),
    grid: color("grid"),
    shadow: Number(color("shadow")),
    ball: color("ball"),
    ballFree: color("ball-free"),
    plate: color("plate"),
    device: color("device"),
    line: color("line"),
    normal: color("normal"),
    force: color("force"),
    rail: color("rail"),
    target: color("target"),
    text: color("text"),
    quiet: color("quiet"),
    rule: color("rule"),
    full: color("full"),
    limit: color("limit"),
  };
}
