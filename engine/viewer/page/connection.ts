// The connection to the server: token, hello, reconnecting, and requests with their answers.

import {
  decodeBinary, encodePointer, kVersion, type Answer, type State, type Ticks, type Vector3,
} from "./protocol.ts";

// Close codes of the server.
const kWrongToken = 4401; // a token that came late has another code, and the page tries again
const kTooManyPages = 1013;
// Answers of the server to a request with a method that it does not know.
const kForbidden = 403;
const kNotAllowed = 405;
// One connection that fails may be that of a server which has just started.
const kFailuresOfProxy = 3;
const kFirstDelay_ms = 250;
const kLongestDelay_ms = 2000;
const kTokenKey = "palpate-token ";

// The folder of an address, which ends with a slash: where a proxy shows the server.
export function folderOf(address: string): URL {
  return new URL(".", address);
}

// The address of the live connection of a page: its host and folder, encrypted if the page is.
export function liveAddress(address: string): string {
  const live = new URL("live", folderOf(address));
  live.protocol = live.protocol === "https:" ? "wss:" : "ws:";
  return live.href;
}

// Servers behind one proxy share their origin, and with it the storage of a tab.
function tokenKey(): string {
  return kTokenKey + folderOf(location.href).pathname;
}

export type ConnectionState =
  | "connecting" // for the first time
  | "live"
  | "lost" // the connection ended; the page tries again
  | "full" // as many pages are open as the server admits; the page tries again
  | "new address" // the token is wrong: the server was restarted
  | "refused" // the server does not serve a page of this origin; the page tries again
  | "no sockets" // a proxy passes requests, but no WebSocket; the page tries again
  | "no token" // the page was opened without the address that the program printed
  | "wrong version"; // the server speaks another version; only a reload helps

// Greeting and Message: the JSON that a server sends to this page; answers belong to the connection.
export interface Greeting {
  type: "hello";
  version: number;
}
export interface ConnectionEvents<Hello extends Greeting, Message> {
  changed(state: ConnectionState): void;
  hello(hello: Hello): void;
  state(state: State): void;
  ticks(ticks: Ticks): void;
  message(message: Message): void;
}

// How a connection ended.
export interface End {
  code: number;
  wasOpen: boolean;
  failures: number; // connections of this page up to this one, if none was ever open; else 0
  status: number | null; // of the answer to a request that the server refuses; null: not asked, or none
}

export function stateAfter(end: End): ConnectionState {
  if (end.code === kWrongToken) return "new address";
  if (end.wasOpen) return end.code === kTooManyPages ? "full" : "lost";
  if (end.status === kForbidden) return "refused";
  return end.status === kNotAllowed && end.failures >= kFailuresOfProxy ? "no sockets" : "lost";
}

// Takes the token out of the address bar, or from the storage of this tab.
export function takeToken(): string | null {
  const inAddress = location.hash.slice(1);
  if (/^[0-9a-f]{32}$/.test(inAddress)) {
    sessionStorage.setItem(tokenKey(), inAddress);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(tokenKey());
}

// The bytes of a scene. path: such as "felt.glb". Throws an Error.
export async function fetchScene(path: string, token: string | null): Promise<ArrayBuffer> {
  const answer = await fetch(path, { headers: { "Palpate-Token": token ?? "" } });
  if (!answer.ok) throw new Error(`/${path}: the server answers ${answer.status}`);
  return answer.arrayBuffer();
}

export class Connection<Hello extends Greeting, Message extends { type: string }> {
  private socket: WebSocket | null = null;
  private isGreeted = false;
  private hasOpened = false;
  private failures = 0;
  private delay_ms = kFirstDelay_ms;
  private nextId = 1;
  private nextPointer = 1;
  private readonly waiting = new Map<number, (answer: Answer) => void>();

  constructor(private readonly token: string, private readonly events: ConnectionEvents<Hello, Message>) {}

  open(): void {
    const socket = new WebSocket(liveAddress(location.href));
    socket.binaryType = "arraybuffer";
    let isOpened = false;
    socket.onopen = () => {
      isOpened = this.hasOpened = true;
      socket.send(JSON.stringify({ type: "token", token: this.token }));
    };
    socket.onmessage = (message) => this.receive(message.data as string | ArrayBuffer);
    socket.onclose = (close) => void this.closed(close.code, isOpened);
    this.socket = socket;
  }

  get isLive(): boolean {
    return this.isGreeted;
  }

  // The sequence of the last pointer message; 0: none.
  get lastPointer(): number {
    return this.nextPointer - 1;
  }

  // Sends a request. The answer of a connection that ends is a problem.
  request(request: { type: string }): Promise<Answer> {
    const id = this.nextId++;
    if (!this.isGreeted || !this.socket) {
      return Promise.resolve({ type: "answer", id, ok: false, problem: "not connected" });
    }
    this.socket.send(JSON.stringify({ ...request, id }));
    return new Promise((resolve) => this.waiting.set(id, resolve));
  }

  // Sends what has no answer. Without a connection it is lost.
  tell(notice: { type: string }): void {
    if (this.isGreeted) this.socket?.send(JSON.stringify(notice));
  }

  // Sends the target of the hand; returns the sequence of the message, or 0 if not connected.
  point(target_m: Vector3, isHeld: boolean, isClutched = false): number {
    if (!this.isGreeted || !this.socket) return 0;
    const sequence = this.nextPointer++;
    this.socket.send(encodePointer(sequence, target_m, isHeld, isClutched));
    return sequence;
  }

  private receive(data: string | ArrayBuffer): void {
    if (typeof data === "string") {
      this.receiveJson(JSON.parse(data) as Hello | Answer | Message);
      return;
    }
    const message = decodeBinary(data);
    if (message.kind === "state") this.events.state(message.state);
    else this.events.ticks(message.ticks);
  }

  private receiveJson(json: Hello | Answer | Message): void {
    if (json.type === "hello") this.greet(json as Hello);
    else if (json.type === "answer") this.answered(json as Answer);
    else this.events.message(json as Message);
  }

  private greet(hello: Hello): void {
    if (hello.version !== kVersion) {
      this.stop("wrong version");
      return;
    }
    this.isGreeted = true;
    this.delay_ms = kFirstDelay_ms;
    this.events.hello(hello);
    this.events.changed("live");
  }

  private answered(answer: Answer): void {
    this.waiting.get(answer.id)?.(answer);
    this.waiting.delete(answer.id);
  }

  private stop(state: ConnectionState): void {
    if (this.socket) {
      this.socket.onclose = null;
      this.socket.close();
    }
    this.end();
    this.events.changed(state);
  }

  private end(): void {
    this.socket = null;
    this.isGreeted = false;
    for (const [id, resolve] of this.waiting) {
      resolve({ type: "answer", id, ok: false, problem: "the connection ended" });
    }
    this.waiting.clear();
  }

  private async closed(code: number, wasOpen: boolean): Promise<void> {
    this.end();
    this.failures = this.hasOpened ? 0 : this.failures + 1;
    const status = wasOpen ? null : await statusOfRefusal();
    const state = stateAfter({ code, wasOpen, failures: this.failures, status });
    this.events.changed(state);
    if (state === "new address") return;
    setTimeout(() => this.open(), this.delay_ms);
    this.delay_ms = Math.min(2 * this.delay_ms, kLongestDelay_ms);
  }
}

// A page is not told why a WebSocket could not be opened. A request with a method that the server does
// not answer carries the origin of the page, too: 403 means that the server does not accept it, 405
// that it does. null: the server cannot be reached.
async function statusOfRefusal(): Promise<number | null> {
  try {
    const signal = AbortSignal.timeout(kLongestDelay_ms);
    return (await fetch("live", { method: "POST", signal })).status;
  } catch {
    return null;
  }
}
