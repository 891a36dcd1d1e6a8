// The pages of `palpate experiment live`: that of a participant, with the course, step by step, and the
// trials; and that of the experimenter, if the address is theirs.

import "./live.css";

import { Connection, fetchScene, takeToken, type ConnectionState } from "./connection.ts";
import { make, makeButton } from "./dom.ts";
import { experimenterConnectionWords, ExperimenterPage } from "./experimenter_page.ts";
import { Screen } from "./live_screens.ts";
import {
  kEnds, type Checked, type ExperimenterHello, type ExperimenterMessage, type ExperimenterRequest,
  type LiveHello, type LiveMessage, type LiveRequest, type Step,
} from "./live_protocol.ts";
import { Words, type WordKey } from "./live_words.ts";
import type { Answer, State } from "./protocol.ts";
import { TrialView } from "./trial_view.ts";

const kConnectionWords: Record<ConnectionState, WordKey | null> = {
  connecting: "connecting", live: null, lost: "connection_lost", full: "connection_full",
  "new address": "connection_new_address", refused: "connection_refused",
  "no sockets": "connection_no_sockets", "no token": "connection_no_token",
  "wrong version": "connection_wrong_version",
};
const kNotConnected: Answer = { type: "answer", id: 0, ok: false, problem: "not connected" };

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

class LivePage {
  private readonly words = new Words();
  private readonly token = takeToken();
  private readonly connection: Connection<LiveHello | ExperimenterHello, LiveMessage | ExperimenterMessage> | null;
  private trial: TrialView | null = null;
  private experimenter: ExperimenterPage | null = null; // null: this is a participant's page
  private hello: LiveHello | null = null;
  private step: Step | null = null;
  private screen: Screen | null = null;
  private state: State | null = null;
  private onPicture: ((time_ms: number, state: State) => void) | null = null;

  constructor() {
    this.connection = this.token ? new Connection(this.token, {
      changed: (state) => this.connectionChanged(state),
      hello: (hello) => (hello.role === "experimenter" ? this.greetExperimenter(hello) : this.greet(hello)),
      state: (state) => this.receiveState(state),
      ticks: () => {}, // are the experimenter's
      message: (message) => this.receive(message),
    }) : null;
    addEventListener("hashchange", () => location.reload()); // another address, pasted into this tab
    this.publishProbe();
    this.connectionChanged(this.connection ? "connecting" : "no token");
    this.connection?.open();
  }

  private openTrial(): TrialView | null {
    try {
      return new TrialView(element("trial"), this.words, {
        ask: (request) => this.ask(request),
        tell: (notice) => this.connection?.tell(notice),
        point: (target_m, isHeld, isClutched) => void this.connection?.point(target_m, isHeld, isClutched),
        fetchScene: () => fetchScene("felt.glb", this.token),
        pause: () => void this.pause(),
        stop: () => this.askStop(),
        say: (problem) => this.say(problem),
      }, (time_ms) => {
        const drawn = this.trial?.shown.drawn;
        if (drawn) this.onPicture?.(time_ms, drawn);
      });
    } catch {
      this.say(this.words.get("no_webgl"));
      return null;
    }
  }

  private async ask(request: LiveRequest | ExperimenterRequest): Promise<Answer> {
    return this.connection?.request(request) ?? kNotConnected;
  }

  private connectionChanged(state: ConnectionState): void {
    const key = kConnectionWords[state];
    element("connection").textContent =
      this.experimenter ? experimenterConnectionWords[state] : key ? this.words.get(key) : "";
    element("connection").hidden = key === null;
    document.body.dataset["connection"] = state;
    if (state !== "live") this.trial?.hide();
  }

  private greetExperimenter(hello: ExperimenterHello): void {
    this.experimenter ??= new ExperimenterPage({
      ask: (request) => this.ask(request),
      fetchScene: () => fetchScene("felt.glb", this.token),
    });
    this.experimenter.greet(hello);
  }

  private greet(hello: LiveHello): void {
    this.hello = hello;
    this.trial ??= this.openTrial();
    this.words.set(hello.words);
    document.documentElement.lang = hello.language;
    document.documentElement.dir = hello.direction;
    document.title = this.words.get("page_title");
    this.makeStop();
    this.trial?.greet(hello, hello.checked ?? null);
    this.showStep(hello.step);
  }

  private receiveState(state: State): void {
    this.state = state;
    this.trial?.receive(state);
    this.experimenter?.receiveState(state);
  }

  private receive(message: LiveMessage | ExperimenterMessage): void {
    if (this.experimenter) this.experimenter.receive(message as ExperimenterMessage);
    else this.receiveAsParticipant(message as LiveMessage);
  }

  private receiveAsParticipant(message: LiveMessage): void {
    switch (message.type) {
      case "step": return this.showStep(message);
      case "trial":
        this.closeScreen();
        void this.trial?.start(message);
        return;
      case "trial_end": return this.trial?.end(message.number);
      case "ring": return this.trial?.ring(message.p_scene_m);
      case "status":
        if (typeof message.remaining_s === "number") this.screen?.setRemaining(message.remaining_s);
        return;
    }
  }

  private showStep(step: Step): void {
    this.trial?.hide();
    this.closeScreen();
    this.closeDialog();
    this.step = step;
    this.say(this.trial ? "" : this.words.get("no_webgl"));
    element("course").hidden = false;
    element("stop").hidden = kEnds.includes(step.step);
    if (kEnds.includes(step.step) && document.fullscreenElement) void document.exitFullscreen();
    this.screen = new Screen(element("screen"), step, {
      words: this.words,
      inputs: this.hello?.inputs ?? [],
      clutchHint: () => this.trial?.clutchHint("instructions") ?? "",
      ask: (request) => this.ask(request),
      say: (problem) => this.say(problem),
      capture: async () => (await this.trial?.capture()) ?? false,
      checked: (checked: Checked) => this.trial?.setChecked(checked),
    });
  }

  private closeScreen(): void {
    this.screen?.close();
    this.screen = null;
    element("course").hidden = true;
  }

  private async pause(): Promise<void> {
    const answer = await this.ask({ type: "pause" });
    if (!answer.ok) this.say(this.words.get("refused", { problem: answer.problem ?? "" }));
  }

  // "": nothing.
  private say(problem: string): void {
    element("notice").textContent = problem;
    element("notice").hidden = problem === "";
  }

  private makeStop(): void {
    const button = makeButton(this.words.get("stop"), () => this.askStop());
    element("stop").replaceChildren(button);
  }

  private askStop(): void {
    this.trial?.interrupt(); // also frees the pointer
    const dialog = element<HTMLDialogElement>("stop-dialog");
    const stop = async (keep: boolean): Promise<void> => {
      const answer = await this.ask({ type: "stop", keep });
      dialog.close();
      if (!answer.ok) this.say(this.words.get("refused", { problem: answer.problem ?? "" }));
    };
    const title = make("h2", "", this.words.get("stop_title"));
    title.id = "stop-title";
    dialog.replaceChildren(title, make("p", "text", this.words.get("stop_text")), make("div", "buttons column",
      makeButton(this.words.get("stop_back"), () => dialog.close(), "main"),
      makeButton(this.words.get("stop_keep"), () => stop(true)),
      makeButton(this.words.get("stop_delete"), () => stop(false))));
    if (!dialog.open) dialog.showModal();
  }

  private closeDialog(): void {
    element<HTMLDialogElement>("stop-dialog").close();
  }

  // What tests read. It holds no token.
  private publishProbe(): void {
    const shown = () => this.trial?.shown ?? this.experimenter?.shown;
    const probe = {
      state: () => this.state,
      step: () => this.step?.step ?? null,
      phase: () => this.trial?.phase ?? "none",
      pictures: () => shown()?.pictures ?? 0,
      drawnBodies: () => shown()?.drawnBodies ?? 0,
      drawnTick: () => shown()?.drawnTick ?? -1,
      green: () => this.trial?.green ?? null, // centre of the green sphere, scene frame
      pixels_per_m: () => shown()?.pixels_per_m ?? NaN,
      sent: () => this.connection?.lastPointer ?? 0, // sequence of the last pointer message
      onPicture: (call: (time_ms: number, state: State) => void) => (this.onPicture = call),
    };
    Object.defineProperty(window, "palpate", { value: Object.freeze(probe) });
  }
}

new LivePage();
