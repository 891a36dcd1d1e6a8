// Full screen and pointer lock of the whole page. Both need a click or a key press just before.

export type LockKind = "unadjusted" | "plain"; // plain: the system may accelerate the pointer

const root = (): HTMLElement => document.documentElement;
let lastKind: LockKind = "plain";

export function isLocked(): boolean {
  return document.pointerLockElement === root();
}

// Of a screen that the page or the key F11 has filled.
const filled = matchMedia("(display-mode: fullscreen)");

export function fillsScreen(): boolean {
  return document.fullscreenElement !== null || filled.matches;
}

// CSS pixels for each unit of movementX and movementY, in which browsers leave out the zoom of the page. The
// window has the same width in both; its borders would count, but a filled screen has none.
export function movement_px(): number {
  return fillsScreen() && outerWidth > 0 ? innerWidth / outerWidth : 1;
}

export function onScreenChange(call: () => void): void {
  document.addEventListener("fullscreenchange", call);
  filled.addEventListener("change", call);
}

// Waits until a lock without a promise is granted or refused.
function lockEnds(): Promise<void> {
  return new Promise((resolve, reject) => {
    document.addEventListener("pointerlockchange", () => resolve(), { once: true });
    document.addEventListener("pointerlockerror", () => reject(new Error("refused")), { once: true });
  });
}

// Locks the pointer, without the acceleration of the system if the browser can. null: refused, as for
// a second after the person has left a lock.
export async function lockPointer(): Promise<LockKind | null> {
  if (isLocked()) return lastKind;
  try {
    // Only a browser that returns a promise knows the option.
    const asked = root().requestPointerLock({ unadjustedMovement: true }) as Promise<void> | undefined;
    await (asked ?? lockEnds());
    lastKind = asked ? "unadjusted" : "plain";
    return lastKind;
  } catch (problem) {
    if (!(problem instanceof DOMException && problem.name === "NotSupportedError")) return null;
  }
  try {
    await root().requestPointerLock();
    lastKind = "plain";
    return lastKind;
  } catch {
    return null;
  }
}

export interface Way {
  x: number; // as movementX and movementY
  y: number;
}
let way: Way | null = null;

// How far the window has moved backwards to fill the screen, once; null: not since the last call.
export function takeWindowWay(): Way | null {
  const taken = way;
  way = null;
  return taken;
}

// Returns false if the browser refuses. Waits until the window has its place, which Chromium does not.
export async function fillScreen(): Promise<boolean> {
  if (fillsScreen()) return true;
  const [x, y] = [screenX, screenY];
  const isPlaced = new Promise((resolve) =>
    document.addEventListener("fullscreenchange", resolve, { once: true }));
  try {
    await root().requestFullscreen({ navigationUI: "hide" });
    await isPlaced;
    if (screenX !== x || screenY !== y) way = { x: x - screenX, y: y - screenY };
    return true;
  } catch {
    return false;
  }
}

// Both at once: the lock first, because full screen uses up the click.
export async function capture(needsLock: boolean): Promise<boolean> {
  const locked = needsLock ? (await lockPointer()) !== null : true;
  return (await fillScreen()) && locked;
}
