// The page of `palpate view`: connects the server, the view, the hand, the controls and the charts.

import "./theme.css";

import { Charts } from "./charts.ts";
import { Connection, fetchScene, takeToken, type ConnectionState } from "./connection.ts";
import { SettingControls } from "./controls.ts";
import { Keys } from "./keys.ts";
import { PageButtons } from "./page_buttons.ts";
import { kUncalibrated_px_per_mm, PaperDisplay } from "./paper_display.ts";
import { Hand } from "./pointer.ts";
import { Pointing } from "./pointing.ts";
import { publishProbe, type PictureListener } from "./probe.ts";
import type { Hello, Request, ServerEvent, State, Status, Ticks } from "./protocol.ts";
import { StatusPanel } from "./status.ts";
import { applyTheme, chooseTheme, chosenTheme } from "./theme.ts";
import { View3d } from "./view3d.ts";
import { length } from "./words.ts";

const kAgeCheck_ms = 50;
const kRetry_ms = 2000; // until the scene is asked for again

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

// null: the browser has no WebGL.
function openDrawing<Drawing>(canvas: HTMLCanvasElement, make: () => Drawing): Drawing | null {
  try {
    return make();
  } catch {
    canvas.hidden = true;
    element("key").hidden = true;
    element("no-webgl").hidden = false;
    element("no-webgl").textContent =
      "This browser has no WebGL, so that the scene is not drawn. Numbers and charts are live.";
    return null;
  }
}

class Page {
  private readonly canvas = element<HTMLCanvasElement>("view");
  private readonly status = new StatusPanel();
  private readonly keys = new Keys();
  private view: View3d | null = null; // the full page
  private paper: PaperDisplay | null = null; // in place of it
  private pictureListener: PictureListener | null = null;
  private readonly charts = new Charts(element("angle-chart"), element("force-chart"));
  private readonly settings: SettingControls;
  private readonly buttons: PageButtons;
  private readonly connection: Connection<Hello, Status | ServerEvent> | null;
  private readonly token = takeToken();
  private pointing: Pointing | null = null;
  private hand: Hand | null = null;
  private hello: Hello | null = null;
  private state: State | null = null;
  private lastStatus: Status | null = null;
  private isInControl = false;
  private hadControl = false; // while it was connected last

  constructor() {
    this.buttons = new PageButtons(this.keys, this.actions());
    this.settings = new SettingControls(
      element("settings"), element("materials"), this.keys,
      (name, value) => this.request({ type: "set", name, value }),
      (problem) => this.status.say(problem));
    this.connection = this.token ? new Connection<Hello, Status | ServerEvent>(this.token, {
      changed: (state) => this.connectionChanged(state),
      hello: (hello) => this.greet(hello),
      state: (state) => this.receiveState(state),
      ticks: (ticks) => this.receiveTicks(ticks),
      message: (message) =>
        message.type === "status" ? this.receiveStatus(message) : this.receiveEvent(message),
    }) : null;
    this.listen();
    publishProbe({
      view: () => this.view, paper: () => this.paper, charts: this.charts, settings: this.settings,
      state: () => this.state, hello: () => this.hello, status: () => this.lastStatus,
      isLive: () => this.status.isLive, sent: () => this.connection?.lastPointer ?? 0,
      onPicture: (call) => (this.pictureListener = call),
    });
    this.buttons.enable(false);
    if (this.connection) this.connection.open();
    else this.status.showConnection("no token");
    this.loop();
  }

  private listen(): void {
    addEventListener("keydown", (event) => this.keyDown(event));
    // The address of a server that was started again, pasted into this tab.
    addEventListener("hashchange", () => location.reload());
    addEventListener("pagehide", () => this.hand?.release());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.hand?.release();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      applyTheme(chosenTheme());
      this.repaint();
    });
    this.canvas.addEventListener("webglcontextlost", () => this.showDrawing(
      "The browser has stopped the drawing. Numbers and charts are live; a reload draws again."));
    this.canvas.addEventListener("webglcontextrestored", () => this.showDrawing(""));
    new ResizeObserver(() => (this.view ?? this.paper)?.resize()).observe(this.canvas);
    setInterval(() => this.status.checkAge(performance.now()), kAgeCheck_ms);
  }

  // Says why the scene is not drawn; "": it is.
  private showDrawing(problem: string): void {
    element("no-webgl").textContent = problem;
    element("no-webgl").hidden = problem === "";
  }

  private actions() {
    return {
      start: () => {
        this.hand?.letGo(); // else its next message would take the hand back
        void this.tell({ type: "start" });
      },
      pause: () => {
        this.hand?.letGo();
        void this.tell({ type: "pause", value: !(this.state?.isPaused ?? false) });
      },
      rearm: () => void this.tell({ type: "rearm" }),
      stay: () => void this.tell({ type: "stay" }),
      takeControl: () => void this.tell({ type: "take_control" }),
      letGo: () => this.hand?.release(),
      camera: () => this.switchCamera(),
      fit: () => this.view?.fit(),
      zoom: (factor: number) => this.view?.zoomBy(factor),
      triangles: (isShown: boolean) => {
        if (this.view) this.view.triangles = isShown;
      },
      loadAll: () => void this.loadScene("felt.glb?full"),
      screenshot: () => void this.screenshot(),
      theme: () => {
        chooseTheme(chosenTheme() === "dark" ? "light" : "dark");
        this.repaint();
      },
    };
  }

  private async request(request: Request) {
    return this.connection ? this.connection.request(request)
                           : { type: "answer" as const, id: 0, ok: false, problem: "not connected" };
  }

  // A request whose refusal is said.
  private async tell(request: Request): Promise<void> {
    const answer = await this.request(request);
    if (!answer.ok) this.status.say(answer.problem ?? "the server refused the request");
  }

  private connectionChanged(state: ConnectionState): void {
    this.status.showConnection(state);
    this.showControl(state === "live" && (this.hello?.control ?? false));
  }

  private greet(hello: Hello): void {
    const hadControl = this.hello !== null && this.hadControl;
    const isFirst = this.hello === null;
    this.hello = hello;
    if (isFirst) this.open(hello);
    if (hadControl && !hello.control) {
      this.status.say("While this page was disconnected, another page came into control.");
    }
    const { scene, device } = hello;
    element("scene").textContent = `${scene.name} \u00b7 ${device.name}`;
    element("scene").title = element("scene").textContent ?? "";
    element("about").textContent = `Palpate ${hello.engine}. ${scene.triangles} triangles` +
      (scene.simplified ? `, of which the view shows ${scene.shown_triangles} after simplification.` : ".");
    if (hello.display.name === "full") this.settings.build(hello.settings, device.sensors);
    this.status.period_ms = 1000 / hello.rate_Hz;
    this.hand?.letGo();
    this.hand = new Hand(hello, (target, isHeld) => void this.connection?.point(target, isHeld));
    this.canvas.setAttribute("aria-label", this.canvasLabel(hello));
    element("hand-hint").textContent = device.is_simulated ? this.canvasLabel(hello)
      : "The hand is a real one: the page shows it and does not move it.";
    this.view?.greet(hello);
    const drawing = this.view ?? this.paper;
    if (drawing && !this.pointing) {
      this.pointing = new Pointing(this.canvas, drawing, () => this.activeHand(),
                                   () => this.state?.record.device_m ?? null);
    }
    void this.loadScene("felt.glb");
    this.buttons.showSimplified(scene.simplified);
  }

  // Opens the drawing that the server wants.
  private open(hello: Hello): void {
    const { display } = hello;
    if (display.name === "full") {
      this.view = openDrawing(this.canvas, () => new View3d(this.canvas));
      return;
    }
    document.body.classList.add("paper");
    this.buttons.showOnlyHand();
    const settings = { Hz: display.Hz, scale: display.scale, css_px_per_mm: kUncalibrated_px_per_mm,
                       proxyRadius_m: hello.proxy_radius_m };
    this.paper = openDrawing(this.canvas, () => new PaperDisplay(this.canvas, settings, (time_ms) => {
      if (this.paper?.drawn) this.pictureListener?.(time_ms, this.paper.drawn);
    }));
    if (this.paper) this.paper.spheres = display.spheres;
    this.paper?.run();
  }

  private canvasLabel(hello: Hello): string {
    return hello.device.sensors === 2
      ? "Drag, or press the arrow keys, to move the hand. Esc lets go. Wheel, + and \u2212 zoom."
      : "Drag, or press the arrow keys, to move the hand; wheel or Page Up and Page Down for depth. " +
        "Esc lets go. Right button or Shift with a drag or the arrow keys turns the view.";
  }

  // The hand, if this page may move it.
  private activeHand(): Hand | null {
    return this.isInControl && this.hello?.device.is_simulated && !this.state?.isPaused ? this.hand
                                                                                       : null;
  }

  private async loadScene(path: string, hello = this.hello): Promise<void> {
    const drawing = this.view ?? this.paper;
    if (!drawing || hello !== this.hello) return;
    try {
      const glb = await fetchScene(path, this.token);
      if (hello !== this.hello) return; // another connection loads its own
      drawing.load(glb);
      if (path.endsWith("?full")) {
        element("about").textContent = `Palpate ${hello?.engine}. All ${hello?.scene.triangles} triangles.`;
        this.buttons.showSimplified(false);
      }
      if (this.view) element("scale").textContent = `grid ${length(this.view.gridStep_m)}`;
    } catch (problem) {
      if (hello !== this.hello) return;
      this.status.say(`The scene is not shown. ${problem instanceof Error ? problem.message : ""}`);
      // A connection that ends loads the scene when it is back.
      if (this.status.isLive) setTimeout(() => void this.loadScene(path, hello), kRetry_ms);
    }
  }

  private receiveState(state: State): void {
    this.state = state;
    this.status.showState(state, performance.now());
    this.buttons.showPaused(state.isPaused);
    if (this.view) this.view.actuatedAxes = state.axes;
    (this.view ?? this.paper)?.update(state);
  }

  private receiveTicks(ticks: Ticks): void {
    this.charts.add(ticks);
  }

  private receiveStatus(status: Status): void {
    this.lastStatus = status;
    this.status.showStatus(status);
    this.settings.show(status.settings);
    if (status.control !== this.isInControl) this.showControl(status.control);
    this.buttons.showTripped(status.trip !== null);
  }

  private receiveEvent(event: ServerEvent): void {
    this.status.say(event.text);
  }

  private showControl(isInControl: boolean): void {
    this.isInControl = isInControl;
    if (this.status.isLive) this.hadControl = isInControl;
    if (!isInControl) this.hand?.letGo();
    const isWatching = this.status.isLive && !isInControl;
    element("watch-notice").hidden = !isWatching;
    this.settings.enable(isInControl);
    this.buttons.enable(isInControl);
    this.buttons.showWatching(isWatching);
  }

  private switchCamera(): void {
    if (!this.view) return;
    this.hand?.letGo();
    this.view.mode = this.view.mode === "camera" ? "classical" : "camera";
    this.buttons.showCamera(this.view.mode === "camera");
  }

  private async screenshot(): Promise<void> {
    const picture = await this.view?.picture();
    if (!picture) return;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(picture);
    link.download = `palpate-${this.state?.record.tick ?? 0}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  private repaint(): void {
    this.view?.repaint();
    this.charts.repaint();
  }

  private keyDown(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (element<HTMLDialogElement>("help").open) return;
    // Fields of numbers take digits, signs, arrows and the letter e; other letters are keys.
    if (target instanceof HTMLInputElement && !/^([a-df-z]|Escape)$/i.test(event.key)) return;
    if (event.key === " " && target.matches("button, summary")) return; // presses it
    if (this.pointing?.key(event) || this.keys.press(event)) event.preventDefault();
  }

  private loop(): void {
    const frame = (now_ms: number): void => {
      requestAnimationFrame(frame); // first, so that an error in a picture ends only that picture
      this.view?.draw();
      this.charts.draw(now_ms);
    };
    requestAnimationFrame(frame);
  }
}

applyTheme(chosenTheme());
new Page();
