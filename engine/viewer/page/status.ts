// What the page says in words: numbers of the newest tick, the state of the connection, and notices.

import type { ConnectionState } from "./connection.ts";
import type { Status, State } from "./protocol.ts";
import { count, faultsInWords, touchedInWords } from "./words.ts";

const kLongestGap_ms = 250; // an older state is not shown as a present one
// How fast the fastest message is forgotten, s per s: clocks drift, and a machine may stop for a while.
const kForget = 0.02;
const kNone = "\u2013"; // a number that does not exist, such as an angle without contact
const kPeriods = 3; // a state of a slow engine may be that old

const kConnectionWords: Record<ConnectionState, { short: string; notice: string }> = {
  connecting: { short: "Connecting", notice: "" },
  live: { short: "Live", notice: "" },
  lost: { short: "Disconnected", notice: "The connection ended. Trying to reconnect\u2026" },
  full: { short: "Waiting", notice: "Eight pages are open already. Trying again\u2026" },
  "new address": {
    short: "New address",
    notice: "The server was restarted, and its address is new. Open the address that palpate view printed.",
  },
  refused: {
    short: "Refused",
    notice: `The server does not accept pages of ${globalThis.location?.origin}. ` +
      "Start palpate view with this after --allow-origin.",
  },
  "no sockets": {
    short: "Blocked",
    notice: "A proxy between this page and palpate does not pass WebSockets. " +
      "Set it up to pass the path /live as a WebSocket. Trying again\u2026",
  },
  "no token": { short: "No access", notice: "Open the address that palpate view printed." },
  "wrong version": { short: "Reload", notice: "The server has another version. Reload this page." },
};

function element(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element #${id}`);
  return found;
}

function write(id: string, text: string): void {
  const target = element(id);
  if (target.textContent !== text) target.textContent = text;
}

// How much longer a message took than the fastest one. The clocks of server and page have no common
// zero.
export class Journey {
  private fastest_ms = Infinity; // received minus sent
  private last_ms = 0;

  begin(): void {
    this.fastest_ms = Infinity;
  }

  delay_ms(sent_s: number, now_ms: number): number {
    const took_ms = now_ms - 1000 * sent_s;
    const drift_ms = kForget * (now_ms - this.last_ms);
    this.last_ms = now_ms;
    this.fastest_ms = Math.min(this.fastest_ms + drift_ms, took_ms);
    return took_ms - this.fastest_ms;
  }
}

export class StatusPanel {
  private connection: ConnectionState = "connecting";
  private present_ms = -Infinity; // when the last present state was received
  private tick = -1;
  private readonly journey = new Journey();
  private missed = 0;
  period_ms = 1; // of the ticks

  showConnection(state: ConnectionState): void {
    this.connection = state;
    const words = kConnectionWords[state];
    write("connection", words.short);
    element("connection").dataset["state"] = state;
    this.notice("connection-notice", words.notice);
    if (state !== "live") this.checkAge(Infinity);
    else this.journey.begin();
  }

  // now_ms: of performance.now().
  showState(state: State, now_ms: number): void {
    const { record } = state;
    const isNew = record.tick !== this.tick || state.isPaused;
    this.tick = record.tick;
    if (this.journey.delay_ms(state.sent_s, now_ms) <= kLongestGap_ms && isNew) {
      this.present_ms = now_ms;
      document.body.classList.remove("stale");
    }
    const isContact = record.contact !== 0;
    const force_N = Math.hypot(...record.force_device_N);
    const full_N = Math.hypot(...record.full_force_device_N);
    const depth_m = Math.hypot(...record.goal_scene_m.map((v, i) => v - (record.proxy_scene_m[i] ?? 0)));
    write("contact", state.isPaused ? "Paused" : isContact ? "Contact" : "Free");
    element("contact").dataset["state"] = state.isPaused ? "paused" : isContact ? "contact" : "free";
    write("angle", isContact ? `${((record.alpha_rad * 180) / Math.PI).toFixed(1)}\u00b0` : kNone);
    write("force", `${force_N.toFixed(2)} N`);
    write("full", `${full_N.toFixed(2)} N`);
    write("depth", isContact ? `${(1000 * depth_m).toFixed(2)} mm` : kNone);
    write("touched", touchedInWords(state.bodyName, state.materialName) || kNone);
    element("touched").title = touchedInWords(state.bodyName, state.materialName);
    write("hand", state.isHeld ? "held by a page" : "let go");
  }

  showStatus(status: Status): void {
    write("rate", status.rate_Hz === null ? kNone : `${count(status.rate_Hz)} Hz`);
    const delta = status.missed - this.missed;
    this.missed = status.missed;
    write("missed", delta > 0 ? `${count(status.missed)} (+${count(delta)})` : count(status.missed));
    const { step_p50_us: median_us, step_max_us: longest_us } = status;
    write("step", median_us === null || longest_us === null ? kNone
      : `${median_us.toFixed(1)} \u00b5s, longest ${longest_us.toFixed(0)} \u00b5s`);
    write("late", status.late_p999_us === null ? kNone : `${count(status.late_p999_us)} \u00b5s`);
    write("trips", count(status.trips));
    write("faults", faultsInWords(status.faults) || "none");
    this.notice("trip-notice", status.trip
      ? `Tripped: ${status.trip}. The force stays zero until you rearm.` : "");
    this.notice("inside-text", status.inside === null ? ""
      : `The hand begins inside \u201c${status.inside}\u201d, a closed surface. ` +
        "There is no force until it has left, or stays.");
    element("inside-notice").hidden = status.inside === null;
    write("clients", count(status.clients));
  }

  // Marks the state as old if it is.
  checkAge(now_ms: number): void {
    const gap_ms = Math.max(kLongestGap_ms, kPeriods * this.period_ms);
    if (now_ms - this.present_ms > gap_ms) document.body.classList.add("stale");
  }

  // Shows a notice; "": hides it.
  notice(id: string, text: string): void {
    write(id, text);
    element(id).hidden = text === "";
  }

  // Says something once, to all readers.
  say(text: string): void {
    write("said", text);
    element("said").hidden = text === "";
    clearTimeout(this.sayTimer);
    this.sayTimer = window.setTimeout(() => {
      element("said").hidden = true;
      write("said", "");
    }, 6000);
  }
  private sayTimer = 0;

  get isLive(): boolean {
    return this.connection === "live";
  }
}
