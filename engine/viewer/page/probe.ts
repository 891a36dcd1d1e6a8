// What tests read: the newest state, what was drawn, and where. It holds no token.

import { Vector3 } from "three";

import type { Charts } from "./charts.ts";
import type { SettingControls } from "./controls.ts";
import type { Hello, State, Status } from "./protocol.ts";
import type { View3d } from "./view3d.ts";

export interface ProbeParts {
  view: View3d | null;
  charts: Charts;
  settings: SettingControls;
  state(): State | null;
  hello(): Hello | null;
  status(): Status | null;
  isLive(): boolean;
  sent(): number;
}

// Publishes the probe as `palpate` of the window.
export function publishProbe(parts: ProbeParts): void {
  const { view } = parts;
  const probe = {
    state: () => parts.state(),
    hello: () => parts.hello(),
    status: () => parts.status(), // the newest
    isLive: () => parts.isLive(),
    sent: () => parts.sent(), // sequence of the last pointer message; 0: none
    metresPerPixel: (x: number, y: number, z: number) =>
      view?.camera.metresPerPixel(new Vector3(x, y, z)) ?? NaN,
    pictures: () => view?.pictures ?? 0,
    drawnTick: () => view?.drawnTick ?? -1,
    drawnBodies: () => view?.drawnBodies ?? 0,
    isSoftware: () => view?.isSoftware ?? false,
    setting: (name: string) => parts.settings.valueOf(name),
    points: (line: "angle_deg" | "force_N" | "fullForce_N") => parts.charts.points([line]),
    // The matrices of the camera, column by column, and the size of the view.
    camera: () => view && {
      view: view.camera.camera.matrixWorldInverse.toArray(),
      projection: view.camera.camera.projectionMatrix.toArray(),
      isTopView: view.camera.isTopView,
      mode: view.drawnMode,
    },
    pixelOf: (x: number, y: number, z: number) => view?.camera.pixelOf(new Vector3(x, y, z)),
    setFlat: (isFlat: boolean) => {
      if (view) view.flat = isFlat;
    },
  };
  Object.defineProperty(window, "palpate", { value: Object.freeze(probe) });
}
